"""`clew fault`: makes something go wrong in a running fleet."""

from collections.abc import Callable
from pathlib import Path
from typing import Any, TypedDict, Unpack

import click

from clew.verbs.log import RUN
from clew.verbs.options import ROBOTS
from protocol.faults.manual_faults import FaultRequest, request_fault
from protocol.faults.rules import Rule
from protocol.files.reading import understand
from protocol.keys import robot_number


def seconds(text: str | float) -> float:
    """`5s`, `5` and `0.5s` are all seconds."""
    try:
        return float(str(text).removesuffix("s"))
    except ValueError as error:
        raise click.BadParameter(f"must be a number of seconds as in 5s, got {text}") from error


TARGET = click.argument("target")
OTHERS = ("leader", "middle", "tail", "world", "router")
FOR = click.option("--for", "for_s", type=seconds, help="Simulated; to the end of the run, if not given.")
HOW_MANY = click.option(
    "--robots", type=ROBOTS, default=1, show_default=True, help="The target, and those next behind it."
)


@click.group()
@RUN
@click.pass_context
def fault(ctx: click.Context, run: Path) -> None:
    """Make something go wrong in the fleet that is running in RUN, from now on.

    A TARGET is a robot (3 or r3), or whoever is leader, middle or tail, or the router, or the world. Each
    fault is recorded in the run's timeline as fault.injected, with the name that is printed.
    """
    ctx.obj = run


@fault.command()
@TARGET
@HOW_MANY
@click.pass_obj
def kill(run: Path, target: str, robots: int) -> None:
    """SIGKILL."""
    _give(run, {"fault": "kill", "target": _process(target), "robots": robots})


@fault.command()
@TARGET
@HOW_MANY
@FOR
@click.pass_obj
def freeze(run: Path, target: str, robots: int, for_s: float | None) -> None:
    """SIGSTOP, and SIGCONT later."""
    _give(run, {"fault": "freeze", "target": _process(target), "robots": robots, "for_s": for_s})


@fault.command()
@TARGET
@click.pass_obj
def thaw(run: Path, target: str) -> None:
    """SIGCONT, for a robot that is frozen."""
    _give(run, {"fault": "thaw", "target": _process(target)})


@fault.command()
@TARGET
@HOW_MANY
@click.option("--after", "after_s", type=seconds, default=0.0, help="For how long there is no process.")
@click.pass_obj
def restart(run: Path, target: str, robots: int, after_s: float) -> None:
    """SIGKILL, and later a new process that remembers nothing; at once where it is dead already."""
    _give(run, {"fault": "restart", "target": _process(target), "robots": robots, "after_s": after_s})


@fault.command()
@TARGET
@click.option("--by", "delay_s", type=seconds, required=True, help="Each time that it looks.")
@FOR
@click.pass_obj
def slow(run: Path, target: str, delay_s: float, for_s: float | None) -> None:
    """Let a robot take time over whatever it does."""
    _give(run, {"fault": "slow", "target": _process(target), "delay_s": delay_s, "for_s": for_s})


class Limits(TypedDict):
    """Which messages a fault strikes, as the options say it."""

    sender: tuple[str, ...]
    receiver: tuple[str, ...]
    kind: tuple[str, ...]
    probability: float
    for_s: float | None


def _strikes_messages(verb: Callable[..., None]) -> Callable[..., None]:
    """The options that all faults of messages take."""
    options = (
        click.option("--from", "sender", multiple=True, help="Only what this one says; may be repeated."),
        click.option("--to", "receiver", multiple=True, help="Only what this one hears; may be repeated."),
        click.option("--kind", multiple=True, help="Only messages of this kind, as ahead; may be repeated."),
        click.option("--probability", type=click.FloatRange(0.0, 1.0), default=1.0, show_default=True),
        FOR,
        click.pass_obj,
    )
    for option in reversed(options):
        verb = option(verb)
    return verb


@fault.command()
@_strikes_messages
def drop(run: Path, **messages: Unpack[Limits]) -> None:
    """Lose messages."""
    _give_messages(run, {"fault": "drop"}, messages)


@fault.command()
@click.option("--min", "delay_s_min", type=seconds, default=0.0, help="At least so late.")
@click.option("--max", "delay_s_max", type=seconds, required=True, help="At most so late.")
@_strikes_messages
def delay(run: Path, delay_s_min: float, delay_s_max: float, **messages: Unpack[Limits]) -> None:
    """Let messages arrive late, each by a time of its own."""
    rule = {"fault": "delay", "delay_s_min": delay_s_min, "delay_s_max": delay_s_max}
    _give_messages(run, rule, messages)


@fault.command()
@click.option("--copies", type=int, default=1, show_default=True)
@click.option("--max", "delay_s_max", type=seconds, default=0.0, help="Each copy at most so late.")
@_strikes_messages
def duplicate(run: Path, copies: int, delay_s_max: float, **messages: Unpack[Limits]) -> None:
    """Let messages arrive again."""
    _give_messages(run, {"fault": "duplicate", "copies": copies, "delay_s_max": delay_s_max}, messages)


@fault.command()
@click.option("--hold", "hold_s", type=seconds, required=True, help="How long each is held back.")
@_strikes_messages
def reorder(run: Path, hold_s: float, **messages: Unpack[Limits]) -> None:
    """Let later messages overtake."""
    _give_messages(run, {"fault": "reorder", "hold_s": hold_s}, messages)


@fault.command()
@click.option("--bits", type=int, default=1, show_default=True, help="How many are flipped.")
@click.option("--truncate", is_flag=True, help="Cut off anywhere, too.")
@_strikes_messages
def corrupt(run: Path, bits: int, *, truncate: bool, **messages: Unpack[Limits]) -> None:
    """Damage messages."""
    _give_messages(run, {"fault": "corrupt", "bits": bits, "truncate": truncate}, messages)


@fault.command()
@click.argument("group", nargs=-1, required=True)
@click.option("--others", multiple=True, help="The other side, if not all the rest; may be repeated.")
@click.option("--one-way", is_flag=True, help="Only what GROUP says to the others is lost.")
@_strikes_messages
def partition(
    run: Path,
    group: tuple[str, ...],
    others: tuple[str, ...],
    *,
    one_way: bool,
    **messages: Unpack[Limits],
) -> None:
    """Cut GROUP off from the others; `router` as the others cuts it off from everybody."""
    sides = {"group": list(map(_process, group)), "others": list(map(_process, others))}
    _give_messages(run, {"fault": "partition", "one_way": one_way, **sides}, messages)


def _give_messages(run: Path, rule: dict[str, Any], messages: Limits) -> None:
    limits = {
        "from": list(map(_process, messages["sender"])),
        "to": list(map(_process, messages["receiver"])),
        "kind": list(messages["kind"]),
        "probability": messages["probability"],
    }
    _give(run, rule | limits, for_s=messages["for_s"])


def _give(run: Path, rule: dict[str, Any], for_s: float | None = None) -> None:
    source = f"fault {rule['fault']}"
    understand(rule, Rule, source)  # type: ignore[arg-type] # a union of types; so it is said by its own path
    click.echo(request_fault(run, understand({"rule": rule, "for_s": for_s}, FaultRequest, source)))


def _process(name: str) -> str:
    """A robot may be called by its bare number."""
    process = f"r{name}" if name.isdecimal() else name
    if robot_number(process) is None and process not in OTHERS:
        raise click.BadParameter(f"must be a robot (3 or r3), or one of {', '.join(OTHERS)}, got {name}")
    return process
