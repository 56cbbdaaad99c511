"""Each kind of entry has a sentence that says what has happened."""

from typing import get_args

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from msgspec.structs import replace

from protocol.fence import Cause, May
from protocol.timeline import (
    KINDS,
    FaultInjected,
    FenceChanged,
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
    ViewProposed,
)
from protocol.timeline.base import Kind
from protocol.timeline.sentences import CAUSES, SENTENCES, sentence
from tests.support.planned import planned
from tests.support.strands import driving, formed, raised, turn
from tests.support.strategies.message_strategies import values_of


def test_every_cause_has_words() -> None:
    assert set(CAUSES) == set(Cause)


def test_every_kind_has_a_sentence() -> None:
    assert SENTENCES.keys() == KINDS.keys()


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
        (
            "r2",
            StepAbandoned(step=3, epoch=1, x_m=0.0, y_m=0.0),
            "r2 gives up step 3: for too long no scan has let it drive on",
        ),
        (
            "world",
            StepFinished(robot=2, step=3, x_m=0.0, y_m=0.0, clearance_m=0.107),
            "r2 finishes step 3, 0.107 m clear",
        ),
        (
            "r2",
            LinkBroken(neighbour=1, cause="token", silent_s=0.84),
            "r2 breaks its link to r1, silent for 0.8 s, whose token is gone",
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
        ("r2", formed(10_002, 1, 2), "strand formed: r1 < r2"),
        (
            "r2",
            formed(10_002, *range(1, 1001)),
            "strand formed: r1 < r2 < r3 < ... < r1000 (1000 robots)",
        ),
        ("r2", StrandJoined(epoch=10_002, rank=1), "r2 takes place 2 in the strand"),
        (
            "r2",
            ViewProposed(epoch=20_002, cause=Cause.NEIGHBOUR_LOST, about=1, why="r1 is lost"),
            "r2 proposes a view: r1 is lost",
        ),
        (
            *raised(20_002, Cause.NEIGHBOUR_LOST),
            "all bodies stand, because a neighbour is lost: r2 coordinates a view",
        ),
        (
            *raised(30_000, Cause.WORLD_RESTARTED),
            "all bodies stand, because the world has been started again",
        ),
        (*turn(20_002, 1, 4), "r4 has the turn: it alone may drive"),
        (*turn(20_002, 2), "nobody has the turn: all stand"),
        (*driving(20_002, 3, 2, 4), "the strand may drive: r3 leads 3 robots"),
        (
            "world",
            FenceChanged(epoch=30_000, turn=0, may=May.STOPPED, coordinator=0, life="", cause=Cause.OPERATOR),
            "the operator has stopped all bodies",
        ),
        (
            "r2",
            RobotStranded(epoch=20_002, robot=5, reason="no way to its place", by=1),
            "r5 is stranded: no way to its place, the body of r1 is in the way",
        ),
    ],
)
def test_a_sentence_says_what_has_happened(source: str, record: Record, said: str) -> None:
    assert sentence(source, record) == said
