"""What the law of a leader was given when it decided, and what it chose among.

Rule 1: no log has it. Replay up to the decision finds it, by listening to what the law is given.
Rule 2: in one decision a law may be asked several times, since a refused way is closed in the map. The last
        time is the one that decided, and it is asked with the map as it was then.
"""

import math
from collections.abc import Sequence

import numpy as np

from agents.commands import Note
from agents.navigation.law import Seen
from agents.process.journal import Input
from agents.robot import Robot
from clew.log.journals.entries import noted
from clew.log.journals.process import Process
from clew.log.replay import decide, new_core
from protocol.errors import UsageError
from protocol.keys import robot_name
from protocol.laws import overheard
from protocol.timeline import LawFailed, RouteLost, StepPlanned
from protocol.wire.codec import packed
from world.record.lines import Line

HEADINGS = 360  # directions in which a step is tried where the law found none


def asked_for(
    processes: Sequence[Process], lines: Sequence[Line], *, step: int | None, robot: int | None
) -> Seen:
    """What the law was given for a switching step, or, without a step, when a leader last asked it.

    Args:
        processes: all of the run.
        lines: the entries of its timeline.
        step: the number of the step.
        robot: the leader; None: any.

    Raises:
        UsageError: there is no such step, or several robots have planned it; its journal is missing; or this
            version of a core does not decide as recorded.
    """
    whose = None if robot is None else robot_name(robot)
    found = [
        index
        for index, (source, entry) in enumerate(lines)
        if whose in {None, source} and _asks(entry.record, step)
    ]
    has = "no leader has" if whose is None else f"{whose} has never"
    of_step = f"{has} asked a law" if step is None else f"{has} planned step {step}"
    if not found:
        raise UsageError(f"seen: {of_step}")
    leaders = list(dict.fromkeys(lines[index][0] for index in found))
    if step is not None and len(leaders) > 1:
        raise UsageError(f"seen: {' and '.join(leaders)} have planned step {step}: say which, as robot=...")
    for index in reversed(found):
        if (seen := _given(processes, lines, index)) is not None:
            return seen
    raise UsageError(f"seen: {of_step}")


def _asks(record: object, step: int | None) -> bool:
    """Whether a leader that recorded this may have asked its law in the same decision."""
    match record:
        case StepPlanned(step=number, joins=False):
            return step in {None, number}
        case RouteLost() | LawFailed():
            return step is None
        case _:
            return False


def _given(processes: Sequence[Process], lines: Sequence[Line], index: int) -> Seen | None:
    source, entry = lines[index]
    place = noted(processes, lines, index)
    if place is None:
        raise UsageError(f"seen: no journal has the decision of {source} at t={entry.t_s:.3f} s")
    process, heard = place.process, place.process.turns[place.turn]
    core = new_core(process.path, process.head)
    for each in process.turns[: place.turn]:
        core.handle(each.event, each.input.now_s)
    seen, is_same = _overheard(core, process, heard.input, packed(heard.decision))
    if not is_same:
        then = f"{source} decides otherwise at t={entry.t_s:.3f} s than recorded"
        raise UsageError(f"seen: {then} (`clew replay` shows where)")
    return seen


def asked_in(process: Process, turn: int) -> StepPlanned | RouteLost | None:
    """What a leader recorded in this turn after it had asked its law: a planned step, or that it has none."""
    for command in process.commands(turn, only=Note):
        match command:
            case Note(StepPlanned(joins=False) as plan):
                return plan
            case Note(RouteLost() as lost):
                return lost
            case _:
                pass
    return None


def given(core: Robot, process: Process, turn: int) -> Seen | None:
    """What the law was given in a turn; None: it was not asked. The core is as it was before that turn."""
    heard = process.turns[turn]
    return _overheard(core, process, heard.input, b"")[0]


def _overheard(core: Robot, process: Process, heard: Input, recorded: bytes) -> tuple[Seen | None, bool]:
    """Rules 1 and 2; and whether the decision is the recorded one."""
    heard_by_law: list[Seen] = []
    with overheard(process.head.mission.law, heard_by_law.append):
        decided = decide(core, heard)
    return heard_by_law[-1] if heard_by_law else None, packed(decided) == recorded


def chosen(seen: Seen, noted_then: StepPlanned | RouteLost) -> str:
    """What a law could choose a planned step from, or what there was where it found none, in a sentence."""
    if isinstance(noted_then, RouteLost):
        return f"{seen.mission.law}: {'; '.join([*_of_the_goal(seen), _of_no_step(seen)])}"
    said = [*_of_the_goal(seen), _of_the_step(seen, noted_then)]
    if seen.goal is None:
        said.append(_of_gaps(noted_then))
    return f"{noted_then.law}: {'; '.join(said)}"


def _of_no_step(seen: Seen) -> str:
    headings_rad = np.linspace(-math.pi, math.pi, HEADINGS, endpoint=False)
    free_m = seen.free_m(headings_rad)
    longest = int(free_m.argmax())
    said = f"the longest certified step is {free_m[longest]:.3f} m, at {headings_rad[longest]:.3f} rad"
    if seen.ways is None:
        return said
    here_m = float(seen.cost_to_go_m(seen.position[None])[0])
    way = (
        f"the map has a way, with a cost-to-go of {here_m:.3f} m"
        if here_m < math.inf
        else "the map has no way"
    )
    return f"{said}; {way}"


def _of_the_goal(seen: Seen) -> list[str]:
    if seen.goal is None:
        return []
    straight = seen.step_to(seen.goal)
    free_m = min(float(seen.free_m([straight.heading_rad])[0]), straight.length_m)
    where = f"the goal is {straight.length_m:.3f} m off at {straight.heading_rad:.3f} rad"
    return [f"{where}, and {free_m:.3f} m of that are certified"]


def _of_the_step(seen: Seen, plan: StepPlanned) -> str:
    said = f"the step goes {plan.length_m:.3f} m at {plan.heading_rad:.3f} rad"
    if plan.promised_clearance_m is not None:
        said += f", where {float(seen.free_m([plan.heading_rad])[0]):.3f} m are certified"
    if plan.cost_to_go_m is not None and seen.ways is not None:
        here_m = float(seen.cost_to_go_m(seen.position[None])[0])
        said += f", and leaves a cost-to-go of {plan.cost_to_go_m:.3f} m, of {here_m:.3f} m"
    return said


def _of_gaps(plan: StepPlanned) -> str:
    passable = sum(gap.passable for gap in plan.gaps)
    if plan.gap is None or plan.gap >= len(plan.gaps):
        return f"it aims at none of {passable} passable gaps"
    gap = plan.gaps[plan.gap]
    return f"it aims at a gap of {gap.width_m:.3f} m, one of {passable} that are passable"
