"""The sentence about what a fleet was trying when its time was up."""

import pytest
from msgspec.structs import replace

from protocol.fence import Cause, May
from protocol.keys import WORLD
from protocol.timeline import (
    Entry,
    FenceChanged,
    GoalReached,
    Record,
    StepFinished,
    StrandReversed,
    ViewProposed,
)
from tests.support.planned import planned
from tests.support.strands import formed
from world.judge.attempt import Attempt

STEP = replace(planned(7), cost_to_go_m=4.25)
JOINS = replace(planned(1), joins=True)
END = StepFinished(robot=1, step=7, x_m=0.0, y_m=0.0, clearance_m=None)
GOAL = GoalReached(x_m=0.0, y_m=0.0)
BACK = StrandReversed(epoch=10001, cut_m=0.0, end_m=3.0, back_by_m=2.0)
TURN = replace(BACK, back_by_m=0.0)
GIVES_UP = ViewProposed(epoch=30001, cause=Cause.NO_WAY, why="it knows none")
FORMS = ViewProposed(epoch=20003, cause=Cause.BLOCKED, why="it is")


def fence(epoch: int, may: May) -> FenceChanged:
    return FenceChanged(epoch=epoch, turn=0, may=may, coordinator=3, life="1")


TRIED: dict[str, tuple[list[Record], str]] = {
    "nothing yet": ([], "no step had been planned"),
    "a step": ([STEP], "r1 was driving step 7, which ends about 4.2 m before the goal"),
    "a step of a robot that joins": ([JOINS], "no step had been planned"),
    "a step that has ended": ([STEP, END], "r1 had found no step after step 7 since t=2.0 s"),
    "a way back": (
        [STEP, END, BACK, fence(20003, May.NOBODY), fence(20003, May.ALL)],
        "the strand was backing out of a dead end since t=3.0 s; the strand had turned round once",
    ),
    "a lead of the tail": (
        [STEP, END, TURN, fence(20003, May.NOBODY), fence(20003, May.ALL)],
        "the tail was to lead the strand out of a dead end since t=3.0 s; the strand had turned round once",
    ),
    "a lead of the tail after a way back": (
        [STEP, END, BACK, TURN, fence(20003, May.NOBODY), fence(20003, May.ALL)],
        "the tail was to lead the strand out of a dead end since t=4.0 s; "
        "the strand had turned round 2 times",
    ),
    "another leader after one that knew no way": (
        [STEP, END, BACK, GIVES_UP, fence(30001, May.NOBODY), fence(30001, May.ALL)],
        "a leader had known no way on by t=4.0 s; the strand had turned round once",
    ),
    "a step after that": (
        [GIVES_UP, fence(30001, May.NOBODY), fence(30001, May.ALL), STEP],
        "r1 was driving step 7, which ends about 4.2 m before the goal",
    ),
    "a step after two ways back": (
        [BACK, BACK, STEP],
        "r1 was driving step 7, which ends about 4.2 m before the goal; the strand had turned round 2 times",
    ),
    "a view": (
        [STEP, FORMS, fence(20003, May.NOBODY), fence(20003, May.ONE)],
        "the robots had been forming a strand since t=3.0 s (a way stays blocked)",
    ),
    "a step after a view": (
        [FORMS, fence(20003, May.NOBODY), fence(20003, May.ALL), STEP],
        "r1 was driving step 7, which ends about 4.2 m before the goal",
    ),
    "places behind the leader": (
        [STEP, END, GOAL],
        "the leader had reached the goal, and others were on the way to their places",
    ),
    "a strand after the goal of another one": (
        [STEP, END, GOAL, formed(20003, 1, 2), STEP],
        "r1 was driving step 7, which ends about 4.2 m before the goal",
    ),
}


@pytest.mark.parametrize(("records", "sentence"), TRIED.values(), ids=TRIED.keys())
def test_what_was_tried_last_is_said(records: list[Record], sentence: str) -> None:
    attempt = Attempt()
    for number, record in enumerate(records, start=1):
        source = WORLD if isinstance(record, FenceChanged | StepFinished) else "r1"
        attempt.hear(source, Entry(n=number, t_s=float(number), hlc="", record=record))
    assert attempt.sentence == sentence
