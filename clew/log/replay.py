"""Replays the robots of a run: a new core gets the recorded inputs and must make the recorded decisions.

Rule 1: every process of every robot has its own journal (`agents.process.journal`) and gets its own core.
Rule 2: decisions are compared as the journal has them, to the last bit of every number.
Rule 3: a core that raises the recorded exception makes the same decision.
Rule 4: a replay is ok only if the journals are complete. A killed process may leave a torn last record or no
        end; a journal that is damaged in another way, or missing (`clew.log.replay_missing`), is a failure.
"""

from collections.abc import Iterator
from itertools import zip_longest
from pathlib import Path
from typing import Any

import msgspec
from msgspec import Struct

from agents.process.journal import Decision, Head, Input, decision, failure
from agents.robot import Robot
from clew.log.journals.recording import Recording
from clew.log.log import Log, check_one_fleet
from clew.log.replay_missing import Missing, journals_in, missing, told
from clew.log.timeline import Choice, unknown_in
from protocol.errors import UsageError, no_run_in
from protocol.faults.manual_faults import is_running
from protocol.keys import robot_name
from protocol.law_files import look_in
from protocol.laws import find
from protocol.network.session import INPUTS
from protocol.plain import plain
from protocol.wire.codec import packed
from world.record.recorder import EVENTS_FILE


class Difference(Struct, frozen=True, kw_only=True):
    """The first decision of a robot that differs."""

    robot: int
    incarnation: str
    input: int
    """Number of the input, from 1."""
    t_s: float
    key: str
    number: int
    """Number of the message that carried the event."""
    kind: str
    event: Any
    recorded: Any
    replayed: Any


class Replayed(Struct, frozen=True, kw_only=True):
    """The replay of one journal."""

    robot: int
    incarnation: str
    decisions: int
    """How many decisions were compared."""
    flaws: tuple[str, ...]
    """Flaws of the journal; the readable part was compared."""
    damaged: bool
    """Whether a flaw is not one that a killed process leaves; what follows it was not compared."""
    difference: Difference | None


class Replay(Struct, frozen=True, kw_only=True):
    """The replay of a run."""

    ok: bool
    decisions: int
    robots: tuple[Replayed, ...]
    missing: tuple[Missing, ...] | None
    """Processes without a journal; None: unknown, because there is no log."""


def replay(run: Path, robot: int | None = None) -> Replay:
    """Replay a run, or one robot of it, up to the first difference.

    Raises:
        UsageError: there is nothing to replay, or a file is no journal.
    """
    name = "r*" if robot is None else robot_name(robot)
    robots: list[Replayed] = []
    going_on = is_running(run)
    recordings = sorted(journals_in(run, name), key=lambda each: (each.head.robot, each.path.name))
    for recording in recordings:
        robots.append(replay_recording(recording, going_on=going_on))
        if robots[-1].difference is not None:
            break
    decisions = sum(each.decisions for each in robots)
    if decisions == 0 and not any(each.damaged for each in robots):
        raise nothing_to_replay(run, robot)
    gone = missing(run, [each.head for each in recordings], robot)
    ok = not any(each.difference is not None or each.damaged for each in robots)
    ok = ok and all(each.excuse is not None for each in gone or ())
    return Replay(ok=ok, decisions=decisions, robots=tuple(robots), missing=gone)


def nothing_to_replay(run: Path, robot: int | None) -> UsageError:
    """The refusal of a folder without inputs, of all robots or of one."""
    if not run.exists():
        return no_run_in(run)
    check_one_fleet(run)
    if robot is not None and (run / EVENTS_FILE).is_file():
        unknown = unknown_in(Choice(robot=robot), Log(run).header, ())
        if unknown is not None:
            return UsageError(unknown)
    whose = "no inputs" if robot is None else f"no inputs of robot {robot}"
    return UsageError(f"{run}: {whose} to replay in {run / INPUTS}")


def replay_recording(recording: Recording, *, going_on: bool = False) -> Replayed:
    """Replay one journal up to the first difference; of a running fleet, up to now."""
    head = recording.head
    core = new_core(recording.path, head)
    compared, difference = 0, None
    for count, turn in enumerate(recording.turns(), start=1):
        if turn.decision is None:
            break
        decided = decide(core, turn.input)
        compared += 1
        if packed(decided) != packed(turn.decision):
            difference = _difference(recording, count, turn.input, turn.decision, decided)
            break
        if decided.failed is not None:
            break
    return Replayed(
        robot=head.robot,
        incarnation=head.incarnation,
        decisions=compared,
        flaws=() if difference is not None else tuple(_flaws(recording, going_on=going_on)),
        damaged=difference is None and recording.damaged,
        difference=difference,
    )


def new_core(journal: Path, head: Head) -> Robot:
    """The core with which a journal in a run's folder begins; that folder may have the file of its law.

    Raises:
        UsageError: its law is not here, or cannot be loaded.
    """
    look_in(journal.parent.parent)
    find(head.mission.law)
    return Robot(head.robot, head.mission, life=head.life, again=head.again)


def decide(core: Robot, heard: Input) -> Decision:
    """The decision of a core on an input, as a journal has it."""
    try:
        return decision(core.handle(heard.event, heard.now_s))
    except Exception as error:  # rule 3
        return failure(error)


def _difference(
    recording: Recording, count: int, heard: Input, recorded: Decision, decided: Decision
) -> Difference:
    head = recording.head
    return Difference(
        robot=head.robot,
        incarnation=head.incarnation,
        input=count,
        t_s=heard.now_s,
        key=heard.key,
        number=heard.number,
        kind=heard.kind,
        event=msgspec.to_builtins(heard.event),
        recorded=shown(recorded),
        replayed=shown(decided),
    )


def shown(decided: Decision) -> Any:  # noqa: ANN401 - plain data
    """A decision for people and programs."""
    if decided.failed is not None:
        return {"failed": decided.failed}
    return [{"kind": kind, **msgspec.to_builtins(fields)} for kind, fields in decided.commands]


def _flaws(recording: Recording, *, going_on: bool) -> Iterator[str]:
    if recording.damaged:
        yield f"{recording.flaw}; the journal is damaged or of another version, and the rest was not compared"
        return
    if recording.ended is None and going_on:
        yield "the run is still going on: these are its decisions up to now, unless its process has died"
        return
    if recording.flaw is not None:
        yield recording.flaw
    if recording.ended is None:
        yield "the journal has no end: its process was killed, or it failed"
    elif recording.unkept is not None:
        yield recording.unkept


def sentences(replayed: Replay) -> Iterator[str]:
    """A replay for people: a line for each robot, and the first difference in full."""
    yield from map(plain, _sentences(replayed))


def _sentences(replayed: Replay) -> Iterator[str]:
    for each in replayed.robots:
        who = f"robot {each.robot} ({each.incarnation})"
        yield from (f"{who}: {flaw}" for flaw in each.flaws)
        if each.difference is None:
            yield f"{who}: the same {each.decisions} decisions"
        else:
            yield from _told(who, each.difference)
    if replayed.missing is None:
        yield f"without a readable {EVENTS_FILE} it is unknown whether a journal is missing"
    yield from map(told, replayed.missing or ())
    count = f"replayed: {replayed.decisions} decisions of {len(replayed.robots)} processes"
    if replayed.ok:
        yield f"{count}, all the same"
    elif all(each.difference is None for each in replayed.robots):
        yield f"{count}, the same, but some could not be compared"


def _told(who: str, difference: Difference) -> Iterator[str]:
    yield (
        f"{who}: input {difference.input} at t={difference.t_s:.3f} s, {difference.kind} by message "
        f"{difference.number} on {difference.key}, led to another decision"
    )
    yield f"  event: {_json(difference.event)}"
    if not (isinstance(difference.recorded, list) and isinstance(difference.replayed, list)):
        yield f"  recorded: {_json(difference.recorded)}"
        yield f"  replayed: {_json(difference.replayed)}"
        return
    for place, (recorded, replayed) in enumerate(
        zip_longest(difference.recorded, difference.replayed), start=1
    ):
        if recorded == replayed:
            yield f"  command {place}, the same: {_json(recorded)}"
        else:
            yield f"  command {place}, recorded: {_json(recorded)}"
            yield f"  command {place}, replayed: {_json(replayed)}"


def _json(value: Any) -> str:  # noqa: ANN401 - plain data
    return "none" if value is None else msgspec.json.encode(value).decode()
