"""Any order, loss and repetition of letters among three robots, with one crash at most.

The stage asks after every step for F1 to F4, S1 and S2, so a schedule that breaks one fails by itself.
"""

from enum import Enum
from typing import NamedTuple

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from agents.coordinating import formation
from agents.membership import assembly
from agents.membership.states import State
from clew.explore.setting import QUEUE, SCATTERED
from protocol.fence import Change, May
from protocol.timeline import FenceChanged, StrandFormed
from protocol.wire.messages import Drive
from protocol.wire.view import Formation, ViewMessage
from tests.support.stages.view_stage import Places, Post, ViewStage, of
from tests.support.strategies.examples import examples

VIEW = (ViewMessage, Change)
STEPS_MAX = 250
SETTLES_S = 40.0
BENT = ((1.2, 1.5, 0.0), (0.8, 1.2, 0.0), (0.4, 1.5, 0.0))
"""A strand with a corner: its path has three vertices."""


class Fate(Enum):
    """What becomes of the next letter."""

    ARRIVE = "arrive"
    LOSE = "lose"
    REPEAT = "repeat"
    LATER = "later"


class Victim(Enum):
    """Whose process dies."""

    NAMED = "named"  # the robot that has the turn
    COORDINATOR = "coordinator"
    LAST = "last"  # the tail, or one that has to join


fates = st.sampled_from([Fate.ARRIVE] * 4 + [Fate.LOSE, Fate.REPEAT, Fate.LATER])


def of_a_view(post: Post) -> bool:
    """Whether a letter is of a view: between robots, or to the register."""
    return isinstance(post.thing, VIEW)


class Crash(NamedTuple):
    """A process dies after so many steps of the kind, and may be started again."""

    victim: Victim
    after: int
    again: bool

    def strikes(self, stage: ViewStage) -> int:
        """The robot that dies if it is time; 0: none can."""
        fence = stage.fence
        match self.victim:
            case Victim.NAMED:
                return fence.robot if fence.may is May.ONE else 0
            case Victim.COORDINATOR:
                return fence.epoch.robot
            case Victim.LAST:
                return stage.robots[-1]


crashes = st.one_of(
    st.none(), st.builds(Crash, st.sampled_from(Victim), st.integers(0, STEPS_MAX // 2), st.booleans())
)


def play(stage: ViewStage, data: st.DataObject, crash: Crash | None) -> None:
    """Let letters of views meet their fates; a robot may crash."""
    ripe = 0
    for _ in range(STEPS_MAX):
        victim = 0 if crash is None else crash.strikes(stage)
        ripe += bool(victim)
        if crash is not None and victim and ripe == crash.after + 1:
            stage.kill(victim)
            if crash.again:
                stage.start(victim)
        if stage.mail and of_a_view(stage.mail[0]):
            fate = data.draw(fates)
            post = stage.mail[0]
            if fate is Fate.LOSE:
                stage.mail.pop(0)
                continue
            if fate is Fate.LATER:
                stage.mail.append(stage.mail.pop(0))
                continue
            if fate is Fate.REPEAT:
                stage.mail.append(post)
        stage.step()
        assert_one_moves_at_most(stage)


def assert_one_moves_at_most(stage: ViewStage) -> None:
    """Before ALL, the robot that the fence names; under ALL, members only; else nobody."""
    fence, moving = stage.fence, stage.moving()
    if fence.may is May.ONE:
        assert moving <= {fence.robot}
    elif fence.may is May.ALL:
        assert stage.formed is not None
        assert moving <= set(stage.formed.order)
    else:
        assert moving == set()


@settings(max_examples=examples(40), deadline=None)
@given(
    data=st.data(),
    places=st.sampled_from([QUEUE, SCATTERED, SCATTERED]),
    crash=crashes,
)
def test_whatever_becomes_of_the_letters_of_views_one_fence_says_who_moves_and_a_strand_forms_in_the_end(
    data: st.DataObject, places: Places, crash: Crash | None
) -> None:
    stage = ViewStage.begun(places)
    play(stage, data, crash)
    stage.run(lambda: stage.fence.may is May.ALL, s_max=SETTLES_S)

    # Formations of one epoch are equal byte for byte.
    told: dict[tuple[int, int, int], set[Formation]] = {}
    for post in stage.sent(of(Formation)):
        told.setdefault((post.receiver, post.thing.epoch.number, post.thing.first), set()).add(post.thing)
    assert all(len(pieces) == 1 for pieces in told.values())
    noted = [record.epoch for record in stage.records_of(StrandFormed)]
    assert len(noted) == len(set(noted))

    # One number of a turn has one content, and nothing goes back.
    keys = [
        (change.epoch // 10_000, change.epoch % 10_000, change.turn)
        for change in stage.records_of(FenceChanged)
    ]
    assert keys == sorted(set(keys))


@settings(max_examples=examples(25), deadline=None)
@given(missing=st.sets(st.integers(0, 2), min_size=1))
def test_a_member_without_all_pieces_gives_no_order(missing: set[int]) -> None:
    with pytest.MonkeyPatch.context() as patch:
        for module in (formation, assembly):
            patch.setattr(module, "PIECE_VERTICES_MAX", 1)
        stage = ViewStage.begun(BENT)
        stage.raised_by(3)
        stage.lose(lambda post: of(Formation, receiver=1)(post) and post.thing.first in missing)
        stage.run(lambda: stage.fence.may is May.ALL)
        first = len(stage.posted)
        stage.pass_s(1.0)
        ordered = [post for post in stage.posted[first:] if of(Drive, sender=1)(post)]
        assert stage.processes[1].robot.state is State.BOUND
        assert not [post for post in ordered if post.thing.target is not None]
        stage.heal()
        stage.run(lambda: stage.processes[1].robot.state is State.MEMBER, s_max=2.0)
