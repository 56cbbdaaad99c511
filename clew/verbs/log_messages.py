"""`clew log messages`: prints the messages of a run, one a line: what robots received, and what was lost."""

import re
from pathlib import Path
from typing import TYPE_CHECKING, get_args

import click
import msgspec

from clew.log.journals.fate import Fate
from clew.verbs.options import AS_JSON, FINITE, ROBOT, RUN, Word
from clew.verbs.say import say, warn
from protocol.errors import UsageError
from protocol.faults.rules import MessageKind
from protocol.files.names import did_you_mean
from protocol.files.refusals import short
from protocol.keys import WORLD, robot_name, robot_number

if TYPE_CHECKING:
    from clew.log.journals.messages import Message
    from clew.log.timeline import Choice
    from world.record.recorder import Header


class _Link(click.ParamType[tuple[str, str]]):
    """Two processes such as 2,3 or r2,world."""

    name = "A,B"

    def convert(
        self, value: object, param: click.Parameter | None, ctx: click.Context | None
    ) -> tuple[str, str]:
        """The names of both."""
        match = re.fullmatch(r"(r?[1-9]\d{0,8}|world),(r?[1-9]\d{0,8}|world)", str(value), re.ASCII)
        if match is None or match[1].removeprefix("r") == match[2].removeprefix("r"):
            self.fail(
                f"must be two robots, or a robot and the world, as 2,3 or 2,world; got {short(value)}",
                param,
                ctx,
            )
        one, other = (
            each if each == WORLD else robot_name(int(each.removeprefix("r"))) for each in match.groups()
        )
        return one, other


class _Steps(click.ParamType[tuple[int, int]]):
    """One step or a range such as 2-4."""

    name = "N[-M]"

    def convert(
        self, value: object, param: click.Parameter | None, ctx: click.Context | None
    ) -> tuple[int, int]:
        """The first and the last."""
        match = re.fullmatch(r"(\d{1,9})(?:-(\d{1,9}))?", str(value), re.ASCII)
        if match is None or int(match[1]) > int(match[2] or match[1]):
            self.fail(f"must be like 2 or 2-4, got {short(value)}", param, ctx)
        return int(match[1]), int(match[2] or match[1])


@click.command()
@RUN
@click.option("--link", type=_Link(), help="Only messages between these two, as 2,3 or 2,world.")
@click.option("--robot", type=ROBOT, help="Only messages from or to this robot.")
@click.option(
    "--kind", multiple=True, help="Only this kind, as in fault plans: ahead, odometry, ...; repeatable."
)
@click.option(
    "--step", "steps", type=_Steps(), help="Only while these steps of the leader lasted, as 2 or 2-4."
)
@click.option(
    "--fate",
    multiple=True,
    type=Word([each.value for each in Fate]),
    help="Only messages with this fate; repeatable.",
)
@click.option("--from", "from_s", type=FINITE, help="Only from this time on [simulated s].")
@click.option("--to", "to_s", type=FINITE, help="Only up to this time [simulated s].")
@AS_JSON
def messages(
    run: Path,
    *,
    link: tuple[str, str] | None,
    robot: int | None,
    kind: tuple[str, ...],
    steps: tuple[int, int] | None,
    fate: tuple[str, ...],
    from_s: float | None,
    to_s: float | None,
    as_json: bool,
) -> None:
    """Print the messages of a run: those that robots received, and what happened to the others.

    A line has the receiver's time, sender and receiver, the kind, the number on its key, its fate, and the
    content in short. The world keeps no journal: of messages to it, only those that a fault struck and those
    that were refused are known. With --json, each line is a JSON object.
    """
    from clew.log.journals.messages import Chosen, messages_of
    from clew.log.journals.process import gaps, processes_of
    from clew.log.log import Log
    from clew.log.timeline import Choice

    log = Log(run)
    for named in {robot, *map(robot_number, link or ())}:
        _refuse_unknown(Choice(robot=named, from_s=from_s, to_s=to_s), log.header)
    lines = list(log.lines)
    processes = processes_of(log.path.parent)
    name = None if robot is None else robot_name(robot)
    chosen = Chosen(link=link, robot=name, kind=kind, fate=fate, steps=steps, from_s=from_s, to_s=to_s)
    everything = list(messages_of(processes, lines))
    known = {*get_args(MessageKind), *(message.kind for message in everything)}  # of lost ones, their keys
    for each in kind:
        if each not in known:
            raise UsageError(f"there is no kind {each!r}{did_you_mean(each, sorted(known))}")
    found = chosen.of(everything, lines)
    for message in found:
        say(msgspec.json.encode(message.as_dict()).decode() if as_json else line_of(message))
    for gap in gaps(log.path.parent, processes):
        warn(f"not complete: {gap}")
    for flaw in log.flaws:
        warn(f"not complete: {flaw}")
    if not found:
        warn("no message matches")


def _refuse_unknown(choice: "Choice", header: "Header") -> None:
    """Raise `UsageError` where no message of such a run can be chosen."""
    from clew.log.timeline import unknown_in

    unknown = unknown_in(choice, header, ())
    if unknown is not None:
        raise UsageError(unknown)


def line_of(message: "Message") -> str:
    """A message on one line."""
    way = f"{message.sender or '?':>5} -> {message.receiver:<5}"
    fate = str(message.fate) if not message.rule else f"{message.fate} ({message.rule})"
    number = message.number or ""
    return f"{message.t_s:9.3f} {way} {message.kind:<9} {number:>6} {fate:<10} {message.said}".rstrip()
