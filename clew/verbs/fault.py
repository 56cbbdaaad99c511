"""`clew fault`: injects a fault into a running fleet."""

from collections.abc import Callable
from pathlib import Path
from typing import Any, TypedDict, Unpack

import click

from clew.verbs.log import RUN
from clew.verbs.options import robots_option
from protocol.faults.manual_faults import FaultRequest, request_fault
from protocol.faults.rules import Rule
from protocol.files.names import did_you_mean
from protocol.files.reading import understand
from protocol.keys import robot_number


def seconds(text: str | float) -> float:
    """The number of seconds in `5s`, `5` or `0.5s`."""
    try:
        return float(str(text).removesuffix("s"))
    except ValueError as error:
        raise click.BadParameter(f"must be a number of seconds as in 5s, got {text}") from error


TARGET = click.argument("target")
OTHERS = ("leader", "middle", "tail", "world", "router")
FOR = click.option(
    "--for", "for_s", type=seconds, help="Duration in simulated time, as 5s; default: to the end of the run."
)
HOW_MANY = robots_option("Number of robots: the target and the next ones behind it.", default=1)


@click.group()
@RUN
@click.pass_context
def fault(ctx: click.Context, run: Path) -> None:
    """Inject a fault into the fleet that is running in RUN, from now on.

    TARGET is a robot (3 or r3), a role (leader, middle, tail), the router or the world. The verb prints the
    name of the fault. The timeline of the run records each injection under this name as fault.injected.
    """
    ctx.obj = run


@fault.command()
@TARGET
@HOW_MANY
@click.pass_obj
def kill(run: Path, target: str, robots: int) -> None:
    """Kill a process (SIGKILL)."""
    _request(run, {"fault": "kill", "target": _process(target), "robots": robots})


@fault.command()
@TARGET
@HOW_MANY
@FOR
@click.pass_obj
def freeze(run: Path, target: str, robots: int, for_s: float | None) -> None:
    """Stop a process (SIGSTOP); continue it later."""
    _request(run, {"fault": "freeze", "target": _process(target), "robots": robots, "for_s": for_s})


@fault.command()
@TARGET
@click.pass_obj
def thaw(run: Path, target: str) -> None:
    """Continue a frozen robot (SIGCONT)."""
    _request(run, {"fault": "thaw", "target": _process(target)})


@fault.command()
@TARGET
@HOW_MANY
@click.option("--after", "after_s", type=seconds, default=0.0, help="Time without a process, as 2s.")
@click.pass_obj
def restart(run: Path, target: str, robots: int, after_s: float) -> None:
    """Kill a process, and start a new one later.

    The new process remembers nothing. A process that is already dead is started at once.
    """
    _request(run, {"fault": "restart", "target": _process(target), "robots": robots, "after_s": after_s})


@fault.command()
@TARGET
@click.option(
    "--by", "delay_s", type=seconds, required=True, help="Extra time for each round of its loop, as 0.4s."
)
@FOR
@click.pass_obj
def slow(run: Path, target: str, delay_s: float, for_s: float | None) -> None:
    """Make a robot slow in everything that it does."""
    _request(run, {"fault": "slow", "target": _process(target), "delay_s": delay_s, "for_s": for_s})


class Limits(TypedDict):
    """The messages that a fault applies to, by the options."""

    sender: tuple[str, ...]
    receiver: tuple[str, ...]
    kind: tuple[str, ...]
    probability: float
    for_s: float | None


def _for_messages(verb: Callable[..., None]) -> Callable[..., None]:
    """Add the options that all message faults have."""
    options = (
        click.option("--from", "sender", multiple=True, help="Only messages from this sender; repeatable."),
        click.option("--to", "receiver", multiple=True, help="Only messages to this receiver; repeatable."),
        click.option(
            "--kind", multiple=True, help="Only messages of this kind, for example ahead; repeatable."
        ),
        click.option(
            "--probability",
            type=click.FloatRange(0.0, 1.0),
            default=1.0,
            show_default=True,
            help="Share of the messages that suffer, drawn at random.",
        ),
        FOR,
        click.pass_obj,
    )
    for option in reversed(options):
        verb = option(verb)
    return verb


@fault.command()
@_for_messages
def drop(run: Path, **messages: Unpack[Limits]) -> None:
    """Lose messages."""
    _request_for_messages(run, {"fault": "drop"}, messages)


@fault.command()
@click.option("--min", "delay_s_min", type=seconds, default=0.0, help="Least delay.")
@click.option("--max", "delay_s_max", type=seconds, required=True, help="Greatest delay.")
@_for_messages
def delay(run: Path, delay_s_min: float, delay_s_max: float, **messages: Unpack[Limits]) -> None:
    """Delay messages, each by a random time."""
    rule = {"fault": "delay", "delay_s_min": delay_s_min, "delay_s_max": delay_s_max}
    _request_for_messages(run, rule, messages)


@fault.command()
@click.option("--copies", type=int, default=1, show_default=True, help="Number of extra copies.")
@click.option("--max", "delay_s_max", type=seconds, default=0.0, help="Greatest delay of a copy.")
@_for_messages
def duplicate(run: Path, copies: int, delay_s_max: float, **messages: Unpack[Limits]) -> None:
    """Repeat messages."""
    _request_for_messages(run, {"fault": "duplicate", "copies": copies, "delay_s_max": delay_s_max}, messages)


@fault.command()
@click.option("--hold", "hold_s", type=seconds, required=True, help="How long each message is held back.")
@_for_messages
def reorder(run: Path, hold_s: float, **messages: Unpack[Limits]) -> None:
    """Hold messages back; later ones overtake."""
    _request_for_messages(run, {"fault": "reorder", "hold_s": hold_s}, messages)


@fault.command()
@click.option("--bits", type=int, default=1, show_default=True, help="Number of bits to flip.")
@click.option("--truncate", is_flag=True, help="Also cut messages off at a random place.")
@_for_messages
def corrupt(run: Path, bits: int, *, truncate: bool, **messages: Unpack[Limits]) -> None:
    """Damage messages."""
    _request_for_messages(run, {"fault": "corrupt", "bits": bits, "truncate": truncate}, messages)


@fault.command()
@click.argument("group", nargs=-1, required=True)
@click.option(
    "--others", multiple=True, help="A process on the other side; repeatable; default: all the rest."
)
@click.option("--one-way", is_flag=True, help="Lose only messages from GROUP to the others.")
@_for_messages
def partition(
    run: Path,
    group: tuple[str, ...],
    others: tuple[str, ...],
    *,
    one_way: bool,
    **messages: Unpack[Limits],
) -> None:
    """Cut GROUP off from the others.

    With --others router, GROUP is cut off from all processes.
    """
    sides = {"group": list(map(_process, group)), "others": list(map(_process, others))}
    _request_for_messages(run, {"fault": "partition", "one_way": one_way, **sides}, messages)


def _request_for_messages(run: Path, rule: dict[str, Any], messages: Limits) -> None:
    limits = {
        "from": list(map(_process, messages["sender"])),
        "to": list(map(_process, messages["receiver"])),
        "kind": list(messages["kind"]),
        "probability": messages["probability"],
    }
    _request(run, rule | limits, for_s=messages["for_s"])


def _request(run: Path, rule: dict[str, Any], for_s: float | None = None) -> None:
    source = f"fault {rule['fault']}"
    understand(rule, Rule, source)  # type: ignore[arg-type] # a union of types; checked alone, so that an error names its field
    click.echo(request_fault(run, understand({"rule": rule, "for_s": for_s}, FaultRequest, source)))


def _process(name: str) -> str:
    """The name of a process; a bare number is a robot."""
    process = f"r{name}" if name.isdecimal() else name
    if robot_number(process) is None and process not in OTHERS:
        others, near = ", ".join(OTHERS), did_you_mean(name, OTHERS)
        raise click.BadParameter(f"must be a robot (3 or r3), or one of {others}, got {name}{near}")
    return process
