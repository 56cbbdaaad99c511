"""Each kind of entry has a sentence that says what has happened."""

from typing import get_args

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from msgspec.structs import replace

from protocol.timeline import (
    FaultInjected,
    LeaderSucceeded,
    LinkBroken,
    LinkSilent,
    Record,
    RobotDied,
    RobotFailed,
    RobotStranded,
    StepAbandoned,
    StepFinished,
    StrandJoined,
    ViewJoined,
    ViewLeft,
    ViewProposed,
)
from protocol.timeline.base import Kind
from protocol.timeline.sentences import SENTENCES, sentence
from protocol.wire.fence import Cause, May
from tests.support.histories.fenced import fence, formation
from tests.support.planned import planned
from tests.support.strategies.message_strategies import values_of

RAISED = fence(10_002, 0, cause=Cause.NEIGHBOUR_LOST)
FORMED = formation(10_002, 1, 0.6, 0.0, order=(1, 2))


def test_every_kind_has_a_sentence() -> None:
    assert set(SENTENCES) == {kind.__struct_config__.tag for kind in get_args(Record)}


@pytest.mark.parametrize("kind", get_args(Record))
@given(data=st.data())
@settings(max_examples=10)
def test_every_entry_has_a_sentence(kind: type[Kind], data: st.DataObject) -> None:
    assert sentence("r3", data.draw(values_of(kind)))


@pytest.mark.parametrize(
    ("source", "record", "said"),
    [
        ("r2", planned(3), "r2 plans step 3: 1.000 m"),
        ("r2", replace(planned(3), promised_clearance_m=0.1), "r2 plans step 3: 1.000 m, promises 0.100 m"),
        ("r2", replace(planned(1), joins=True), "r2 goes 1.000 m towards its place"),
        ("r2", StepAbandoned(step=3, epoch=1, x_m=0.0, y_m=0.0), "r2 stops before the end of step 3"),
        (
            "world",
            StepFinished(robot=2, step=3, x_m=0.0, y_m=0.0, clearance_m=0.107),
            "r2 finishes step 3, 0.107 m clear",
        ),
        (
            "r2",
            LinkBroken(neighbour=1, cause="token", silent_s=0.84),
            "r2 breaks its link to r1, silent for 0.8 s (token)",
        ),
        ("r2", LinkSilent(neighbour=1, silent_s=0.5), "r2 has not heard r1 for 0.50 s"),
        ("r2", LeaderSucceeded(epoch=2, before=1), "r2 leads instead of r1"),
        ("r2", LeaderSucceeded(epoch=2, before=None), "r2 leads"),
        ("r2", RobotFailed(reason="ValueError"), "r2 has failed: ValueError"),
        ("world", RobotDied(robot=1, silent_since_s=2.9), "r1 has died, silent since t=2.9 s"),
        ("world", FaultInjected(fault="kill", rule="kill-1", process="r1"), "kill-1: kill r1"),
        (
            "r2",
            FaultInjected(fault="drop", rule="loss", key="link/r1/r2", number=7),
            "loss: drop message 7 on link/r1/r2",
        ),
        ("r2", FORMED, "r2 forms the strand r1 < r2"),
        ("r2", StrandJoined(epoch=10_002, rank=1), "r2 takes place 2 in the strand"),
        ("world", RAISED, "epoch 10002, turn 0: no robot may move (neighbour lost)"),
        (
            "world",
            replace(RAISED, turn=1, may=May.ONE, named=3, named_life="3c", cause=None),
            "epoch 10002, turn 1: only r3 may move",
        ),
        ("world", replace(RAISED, turn=2, cause=None), "epoch 10002, turn 2: no robot may move"),
        (
            "world",
            replace(RAISED, turn=3, may=May.ALL, named=1, members=2, cause=None),
            "epoch 10002, turn 3: the strand of 2 robots may move, led by r1",
        ),
        (
            "world",
            replace(RAISED, epoch=20_000, may=May.STOPPED, coordinator=0, life="", cause=Cause.OPERATOR),
            "epoch 20000, turn 0: the operator stops all robots",
        ),
        (
            "r2",
            ViewProposed(epoch=10_002, cause=Cause.PLEA, about=4, why="r4 asks to be let in"),
            "r2 proposes a new view, epoch 10002: r4 asks to be let in",
        ),
        ("r2", ViewJoined(epoch=10_002), "r2 leaves its strand and reports to the view of epoch 10002"),
        ("r2", ViewLeft(epoch=10_002), "r2 is left out of the strand of epoch 10002: it stands aside"),
        (
            "r2",
            RobotStranded(epoch=10_002, robot=4, reason="no way past it"),
            "r4 finds no way to the strand: no way past it",
        ),
        (
            "r2",
            RobotStranded(epoch=10_002, robot=4, reason="no way past it", by=3),
            "r4 finds no way to the strand, the body of r3 is in the way: no way past it",
        ),
    ],
)
def test_a_sentence_says_what_has_happened(source: str, record: Record, said: str) -> None:
    assert sentence(source, record) == said
