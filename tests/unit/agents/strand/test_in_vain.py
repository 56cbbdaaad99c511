"""Attempts of a strand in vain, and when they are too many."""

import numpy as np
import pytest
from msgspec.structs import replace

from agents.liveness.reason import Turnabout
from agents.navigation.step import NoStep
from agents.strand.blocked import BLOCKED_S
from agents.strand.leader import NO_WAY, DeadEnd, Leader, Wait
from agents.strand.leading import PATIENCE_S
from agents.strand.member import IN_VAIN_MAX, TOO_OFTEN
from protocol.fence import Cause
from protocol.frames import Point
from protocol.timeline import RouteLost
from protocol.wire.view import Counters
from tests.support.stages.member_stage import MemberStage, row
from tests.support.stages.one_step import under
from world.geometry.shapes import Circle

MISSION = under("certified", robots=3, robot_radius_m=0.1, separation_m=0.1, goal=Point(x_m=6.0, y_m=0.0))
ORDER = (1, 2, 3)
BOX = Circle(centre_m=(-0.25, 0.0), radius_m=0.1)  # between robots 1 and 2


@pytest.mark.parametrize(("in_vain", "is_lost"), [(IN_VAIN_MAX - 1, False), (IN_VAIN_MAX, True)])
@pytest.mark.parametrize("step", [DeadEnd(0.4), NO_WAY])
def test_after_too_many_attempts_in_vain_the_route_is_lost(
    step: DeadEnd | NoStep, in_vain: int, *, is_lost: bool, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(Leader, "plan", lambda *_, **__: step)
    stage = MemberStage(MISSION, row(3), ORDER, counters=Counters(in_vain=in_vain, heals=1))
    stage.run(3.0)
    assert (stage.leader.reason is None) == is_lost
    assert stage.leader.counters.in_vain == IN_VAIN_MAX
    assert [record.reason for record in stage.records(RouteLost)] == is_lost * [TOO_OFTEN]


def test_a_leader_in_a_dead_end_says_how_far_the_tail_is_to_come_back_and_that_counts_once(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """Else a strand that has come back as often as it may is given up before it has tried its other way."""
    monkeypatch.setattr(Leader, "plan", lambda *_, **__: DeadEnd(0.4))
    stage = MemberStage(MISSION, row(3), ORDER, counters=Counters(in_vain=IN_VAIN_MAX - 1))
    stage.run(3.0)
    reason = stage.leader.reason
    assert reason is not None
    assert reason.turnabout == Turnabout(cut_m=0.0, end_m=1.0, back_by_m=0.6)
    stage.reform(reason.turnabout)
    while stage.leader.reason is None:
        stage.run(1.0)
    assert (stage.leader.reason.cause, stage.leader.counters.in_vain) == (Cause.DEAD_END, IN_VAIN_MAX)
    assert not stage.records(RouteLost)


@pytest.mark.parametrize(("off_m", "cause"), [(-0.9 * MISSION.mu0_m, Cause.NO_WAY), (0.02, Cause.DEAD_END)])
def test_where_a_leader_began_too_near_to_something_another_leads_out_of_the_dead_end(
    off_m: float, cause: Cause, monkeypatch: pytest.MonkeyPatch
) -> None:
    """In a strand that turns round the leg that begins there would count as driven."""
    monkeypatch.setattr(Leader, "plan", lambda *_, **__: DeadEnd(0.4))
    beside_m = MISSION.robot_radius_m + MISSION.clear_m + off_m + 0.1
    stage = MemberStage(MISSION, row(3), ORDER, shapes=[Circle(centre_m=(0.0, beside_m), radius_m=0.1)])
    stage.run(3.0)
    reason = stage.leader.reason
    assert reason is not None
    assert reason.cause is cause
    assert stage.leader.counters.last_to_lead == ((1,) if cause is Cause.NO_WAY else ())


@pytest.mark.parametrize("in_vain", [0, 1])
def test_only_before_an_attempt_in_vain_may_the_tail_lead_out_from_where_it_stands(
    in_vain: int, monkeypatch: pytest.MonkeyPatch
) -> None:
    asked: set[bool] = set()

    def planned(*_: object, tail_may_lead: bool, **__: object) -> Wait:
        asked.add(tail_may_lead)
        return Wait()

    monkeypatch.setattr(Leader, "plan", planned)
    MemberStage(MISSION, row(3), ORDER, counters=Counters(in_vain=in_vain)).run(1.0)
    assert asked == {in_vain == 0}


@pytest.mark.parametrize("comes_on", [False, True])
def test_after_too_many_attempts_in_vain_the_leader_says_for_a_robot_that_is_blocked_that_the_route_is_lost(
    monkeypatch: pytest.MonkeyPatch, *, comes_on: bool
) -> None:
    """In a long run many ways are blocked, one after the other."""
    if not comes_on:
        monkeypatch.setattr(Leader, "plan", lambda *_, **__: Wait())
    stage = MemberStage(MISSION, row(3), ORDER)
    stage.shapes, stage.is_checked, stage.counters = [BOX], False, Counters(in_vain=IN_VAIN_MAX)
    stage.reform(counters=stage.counters)
    stage.run(BLOCKED_S + 3.0)
    reason, counters = stage.members[2].reason, stage.members[2].counters
    assert reason is not None
    assert (reason.cause, counters.in_vain) == (Cause.BLOCKED, 1 if comes_on else IN_VAIN_MAX + 1)
    assert not stage.records(RouteLost), "only the leader may say so"
    stage.reform(counters=counters)
    stage.run(1.0)
    lost = [robot for robot, record in stage.told if isinstance(record, RouteLost)]
    assert lost == ([] if comes_on else [1])


def test_after_as_many_attempts_a_leader_whose_way_is_clear_goes_on() -> None:
    stage = MemberStage(MISSION, row(3), ORDER)
    stage.reform(counters=Counters(in_vain=IN_VAIN_MAX))
    stage.run(1.0)
    assert not stage.records(RouteLost), "its way is clear"


@pytest.mark.parametrize("first", [NO_WAY, DeadEnd(0.4)])
@pytest.mark.parametrize(
    ("counters", "wants"),
    [
        pytest.param(Counters(heals=1), True, id="another may lead"),
        pytest.param(Counters(heals=1, last_to_lead=(1,)), False, id="it is among the last to lead"),
        pytest.param(Counters(), False, id="nobody was lost"),
    ],
)
def test_where_obstacles_move_a_view_in_between_gives_no_new_patience_to_a_leader_that_may_hand_on(
    first: NoStep | DeadEnd, counters: Counters, monkeypatch: pytest.MonkeyPatch, *, wants: bool
) -> None:
    """A robot that asks to be let in makes such a view, and each may take half as long as the patience."""

    def wants_another_to_lead() -> bool:
        return stage.leader.reason is not None and stage.leader.reason.cause is Cause.NO_WAY

    stage = MemberStage(replace(MISSION, obstacle_speed_mps_max=0.1), row(3), ORDER, counters=counters)
    for waited_s, step in ((0.6 * PATIENCE_S, first), (0.3 * PATIENCE_S, NO_WAY)):
        monkeypatch.setattr(Leader, "plan", lambda *_, step=step, **__: step)
        stage.run(waited_s)
        assert not wants_another_to_lead()
        stage.reform(counters=counters)
    stage.run(0.2 * PATIENCE_S)
    assert wants_another_to_lead() is wants
    for told in (stage.leader.counters, counters):  # it leads again, and gets on a little, but not away
        stage.reform(counters=told)
        stage.run(0.3 * PATIENCE_S)
        assert not wants_another_to_lead()
    assert not stage.records(RouteLost)


def test_a_leader_remembers_where_it_first_knew_no_way_until_it_is_a_link_away_or_another_has_led() -> None:
    stage = MemberStage(MISSION, row(3), ORDER)
    memory, link_m = stage.parts[1].memory, MISSION.link_length_m_max
    since_s = []
    for now_s, x_m in enumerate((0.0, 0.9 * link_m, 0.0, 1.1 * link_m, 0.5 * link_m)):
        memory.note_no_way(np.array([x_m, 0.0]), float(now_s))
        since_s.append(memory.no_way_since_s)
    assert since_s == [0.0, 0.0, 0.0, 3.0, 3.0]
    for rank, since in ((0, 3.0), (1, 9.0)):
        memory.take(replace(stage.leader.formation, rank=rank))
        memory.note_no_way(np.array([link_m, 0.0]), 9.0)
        assert memory.no_way_since_s == since
