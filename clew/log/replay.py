"""Replays robots of a run: what each heard, given to a fresh core, has to be decided as it was recorded.

Rule 1: every process of every robot has a journal of its own (`agents.process.journal`) and a core of its
        own.
Rule 2: decisions are compared as they stand in the journal, to the last bit of every number.
Rule 3: a core that fails as it did then decides the same.
Rule 4: "all the same" is said of whole journals only. A killed process may leave a torn last record or no
        end; a journal that is damaged otherwise, or missing (`clew.log.replay_missing`), is a failure.
"""

from collections.abc import Iterator
from itertools import zip_longest
from pathlib import Path
from typing import Any

import msgspec
from msgspec import Struct

from agents.process.journal import SUFFIX, Decision, Input, Recording, decision, failure
from agents.robot import Robot
from clew.log.replay_missing import Missing, missing, told
from protocol.errors import UsageError
from protocol.faults.manual_faults import is_running
from protocol.keys import robot_name
from protocol.network.session import INPUTS
from protocol.plain import plain
from protocol.wire.codec import packed
from world.record.recorder import EVENTS_FILE


class Difference(Struct, frozen=True, kw_only=True):
    """The first decision of a robot that came out otherwise."""

    robot: int
    incarnation: str
    input: int
    """Which one it was, counted from 1."""
    t_s: float
    key: str
    number: int
    """Of the message that the event came by."""
    kind: str
    event: Any
    recorded: Any
    replayed: Any


class Replayed(Struct, frozen=True, kw_only=True):
    """What came of one journal."""

    robot: int
    incarnation: str
    decisions: int
    """How many were compared."""
    flaws: tuple[str, ...]
    """What is wrong with the journal; whatever could be read was compared."""
    damaged: bool
    """Whether one of them is none that a killed process leaves: what is behind it was not compared."""
    difference: Difference | None


class Replay(Struct, frozen=True, kw_only=True):
    """What came of a run."""

    ok: bool
    decisions: int
    robots: tuple[Replayed, ...]
    missing: tuple[Missing, ...] | None
    """Processes without a journal; None: there is no log that says which there were."""


def replay(run: Path, robot: int | None = None) -> Replay:
    """Replay a run, given its folder, up to the first difference; one robot of it, or all.

    Raises:
        UsageError: there is nothing to replay, or a journal does not begin as one.
    """
    name = "r*" if robot is None else robot_name(robot)
    found = list((run / INPUTS).glob(f"{name}-*{SUFFIX}"))
    robots: list[Replayed] = []
    going_on = is_running(run)
    recordings = sorted(map(Recording, found), key=lambda each: (each.head.robot, each.path.name))
    for recording in recordings:
        robots.append(replay_recording(recording, going_on=going_on))
        if robots[-1].difference is not None:
            break
    decisions = sum(each.decisions for each in robots)
    if decisions == 0 and not any(each.damaged for each in robots):
        whose = "no inputs" if robot is None else f"no inputs of robot {robot}"
        raise UsageError(f"{run}: {whose} to replay in {run / INPUTS}")
    gone = missing(run, [each.head for each in recordings], robot)
    ok = not any(each.difference is not None or each.damaged for each in robots)
    ok = ok and all(each.excuse is not None for each in gone or ())
    return Replay(ok=ok, decisions=decisions, robots=tuple(robots), missing=gone)


def replay_recording(recording: Recording, *, going_on: bool = False) -> Replayed:
    """Replay one journal up to the first difference, or up to now where the run is still going on."""
    head = recording.head
    core = Robot(head.robot, head.mission, again=head.again)
    compared, difference = 0, None
    for count, turn in enumerate(recording.turns(), start=1):
        if turn.decision is None:
            break
        decided = _decide(core, turn.input)
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


def _decide(core: Robot, heard: Input) -> Decision:
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
        recorded=_shown(recorded),
        replayed=_shown(decided),
    )


def _shown(decided: Decision) -> Any:  # noqa: ANN401 - plain data, for people and programs
    if decided.failed is not None:
        return {"failed": decided.failed}
    return [{"kind": kind, **msgspec.to_builtins(fields)} for kind, fields in decided.commands]


def _flaws(recording: Recording, *, going_on: bool) -> Iterator[str]:
    if recording.damaged:
        yield f"{recording.flaw}; it is damaged, or of another version, and what follows is not compared"
        return
    if recording.ended is None and going_on:
        yield "the run is still going on: this is what it decided up to now, unless its process has died"
        return
    if recording.flaw is not None:
        yield recording.flaw
    if recording.ended is None:
        yield "it has no end: its process was killed, or has failed"
    elif recording.ended == "full":
        yield "it was full before the run was over"


def sentences(replayed: Replay) -> Iterator[str]:
    """A replay for people, plain: a line for each robot, and the first difference in full."""
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
        yield f"no {EVENTS_FILE} says which processes there were: whether a journal is missing is not known"
    yield from map(told, replayed.missing or ())
    count = f"replayed: {replayed.decisions} decisions of {len(replayed.robots)} processes"
    if replayed.ok:
        yield f"{count}, all the same"
    elif all(each.difference is None for each in replayed.robots):
        yield f"{count}, the same, but not all could be compared"


def _told(who: str, difference: Difference) -> Iterator[str]:
    yield (
        f"{who}: input {difference.input} at t={difference.t_s:.3f} s, {difference.kind} by message "
        f"{difference.number} on {difference.key}, was decided otherwise"
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
