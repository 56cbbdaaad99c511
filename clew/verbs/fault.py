"""`clew fault`: injects a fault into a running fleet, or stops and releases it.

The names of options and arguments are those of the fields of a rule, so one function serves all faults.
"""

from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any

import click

from clew.verbs.group import LateGroup
from clew.verbs.options import RUN_FOLDER, FiniteRange, robots_option
from protocol.errors import UsageError
from protocol.faults.manual_faults import EndRequest, FaultRequest, HaltRequest, Request, request_fault
from protocol.faults.rules import ROLES, ROUTER, Rule
from protocol.files.names import did_you_mean
from protocol.files.reading import understand
from protocol.files.refusals import short
from protocol.keys import WORLD, robot_number

Parameter = Callable[[Callable[..., None]], Callable[..., None]]

OTHERS = (*ROLES, WORLD, ROUTER)


def seconds(text: str | float) -> float:
    """The number of seconds in `5s`, `5` or `0.5s`."""
    try:
        return float(str(text).removesuffix("s"))
    except ValueError as error:
        raise click.BadParameter(f"must be a number of seconds as in 5s, got {short(text)}") from error


def process(name: str) -> str:
    """The name of a process; a bare number is a robot."""
    found = f"r{name}" if name.isdecimal() else name
    if robot_number(found) is None and found not in OTHERS:
        others, near = ", ".join(OTHERS), did_you_mean(name, OTHERS)
        raise click.BadParameter(f"must be a robot (3 or r3), or one of {others}, got {short(name)}{near}")
    return found


def _some(option: str, name: str, text: str, **more: object) -> Parameter:
    return click.option(option, name, multiple=True, help=f"{text}; repeatable.", **more)  # type: ignore[arg-type] # click's own options


def _time(option: str, name: str, text: str, **more: object) -> Parameter:
    return click.option(option, name, type=seconds, help=f"{text}, as 5s.", **more)  # type: ignore[arg-type] # click's own options


TARGET = click.argument("target", type=process)
HOW_MANY = robots_option("Number of robots: the target and the next ones behind it.", default=1)
FOR = click.option(
    "--for", "for_s", type=seconds, help="Duration in simulated time, as 5s; default: to the end of the run."
)
MESSAGES = (
    _some("--from", "from", "Only messages from this sender", type=process),
    _some("--to", "to", "Only messages to this receiver", type=process),
    _some("--kind", "kind", "Only messages of this kind, for example ahead"),
    click.option(
        "--probability",
        type=FiniteRange(0.0, 1.0),
        default=1.0,
        show_default=True,
        help="Share of the messages that the fault strikes, drawn at random.",
    ),
    FOR,
)


@click.group(cls=LateGroup)
@click.argument("run", type=RUN_FOLDER)
@click.pass_context
def fault(ctx: click.Context, run: Path) -> None:
    """Inject a fault into the fleet that is running in RUN, from now on.

    TARGET is a robot (3 or r3), a role (leader, middle, tail, coordinator), the router or the world. The verb
    prints the name of the fault, such as given-1. The timeline of the run records each injection as
    fault.injected under this name; that of a process adds the process: given-1.r3.
    """
    ctx.obj = run


def _asked(run: Path, request: Request) -> str:
    """Ask the world of the run.

    Raises:
        UsageError: as `request_fault`; or it is no run, or has several fleets, each of which has a folder.
    """
    try:
        return request_fault(run, request)
    except UsageError:
        from clew.fleet.runs import check_is_run  # not before it has been asked: a stop is urgent
        from clew.log.log import check_one_fleet

        check_one_fleet(run)
        check_is_run(run)
        raise


def _add(name: str, text: str, parameters: Sequence[Parameter]) -> None:
    """Add the verb of a fault."""

    def request(run: Path, **fields: Any) -> None:  # noqa: ANN401 - fields of a rule have any type
        source = f"fault {name}"
        # The duration of a message fault stands beside its rule, that of a process fault in it.
        for_s = None if "target" in fields else fields.pop("for_s")
        rule = {"fault": name} | fields
        understand(rule, Rule, source)  # type: ignore[arg-type] # a union; checked alone, so that errors name its field
        click.echo(_asked(run, understand({"rule": rule, "for_s": for_s}, FaultRequest, source)))

    verb: Callable[..., None] = click.pass_obj(request)
    for parameter in reversed(parameters):
        verb = parameter(verb)
    fault.command(name, help=text)(verb)


def _add_message_fault(name: str, text: str, *parameters: Parameter) -> None:
    _add(name, text, (*parameters, *MESSAGES))


_add("kill", "Kill a process (SIGKILL).", [TARGET, HOW_MANY])
_add("freeze", "Stop a process (SIGSTOP); continue it later.", [TARGET, HOW_MANY, FOR])
_add("thaw", "Continue a frozen robot (SIGCONT).", [TARGET])
_add(
    "restart",
    "Kill a process, and start a new one later.\n\n"
    "The new process remembers nothing. A process that is already dead is started at once.",
    [TARGET, HOW_MANY, _time("--after", "after_s", "Time without a process", default=0.0)],
)
_add(
    "slow",
    "Make a process react late to everything that arrives.",
    [TARGET, _time("--by", "delay_s", "Delay of each read of its inbox", required=True), FOR],
)
_add_message_fault("drop", "Lose messages.")
_add_message_fault(
    "delay",
    "Delay messages, each by a random time.",
    _time("--min", "delay_s_min", "Least delay", default=0.0),
    _time("--max", "delay_s_max", "Greatest delay", required=True),
)
_add_message_fault(
    "duplicate",
    "Repeat messages.",
    click.option("--copies", type=int, default=1, show_default=True, help="Number of extra copies."),
    _time("--max", "delay_s_max", "Greatest delay of a copy", default=0.0),
)
_add_message_fault(
    "reorder",
    "Hold messages back; later ones overtake.",
    _time("--hold", "hold_s", "How long each message is held back", required=True),
)
_add_message_fault(
    "corrupt",
    "Damage messages.",
    click.option("--bits", type=int, default=1, show_default=True, help="Number of bits to flip."),
    click.option("--truncate", is_flag=True, help="Also cut messages off at a random place."),
)
_add_message_fault(
    "partition",
    "Cut GROUP off from the others.\n\nWith --others router, GROUP is cut off from all processes.",
    click.argument("group", nargs=-1, required=True, type=process),
    _some("--others", "others", "A process on the other side; default: all the rest", type=process),
    click.option("--one-way", is_flag=True, help="Lose only messages from GROUP to the others."),
)


@fault.command
@click.argument("name")
@click.pass_obj
def end(run: Path, *, name: str) -> None:
    """End a message fault by its NAME, which the verb printed when it was given."""
    click.echo(_asked(run, understand({"name": name}, EndRequest, "fault end")))


@fault.command
@click.pass_obj
def stop(run: Path) -> None:
    """Stop all robots (emergency stop) until they are released.

    All bodies stop at once and obey no order to drive. The robots form a strand again after the release.
    """
    click.echo(_asked(run, HaltRequest(stop=True)))


@fault.command
@click.pass_obj
def release(run: Path) -> None:
    """Release the robots after a stop."""
    click.echo(_asked(run, HaltRequest(stop=False)))
