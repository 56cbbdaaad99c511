"""Members of a strand as conversations, with bodies, sensors and a network that loses messages."""

from itertools import pairwise

import pytest
from msgspec.structs import replace

from agents.commands import AskScan, Note
from agents.events import LinkHeard
from agents.liveness.reason import Turnabout
from agents.navigation.step import NoStep
from agents.strand.blocked import BLOCKED_S
from agents.strand.grants import GRANT_M_MIN
from agents.strand.leader import NO_WAY, DeadEnd, Leader, Wait
from agents.strand.leading import SETTLED_S
from protocol.fence import Cause
from protocol.frames import ROBOTS_MAX, Point, Pose, Vertex
from protocol.path import Path
from protocol.timeline import (
    LeaderSucceeded,
    RobotArrived,
    RobotHeld,
    RouteLost,
    SegmentChecked,
    StrandHealed,
    StrandJoined,
)
from protocol.wire.view import Counters
from tests.support.long import long
from tests.support.stages.member_stage import PERIOD_S, MemberStage, row
from tests.support.stages.one_step import under, wall
from world.geometry.shapes import Circle, Shape

MISSION = under(
    "certified",
    robots=3,
    robot_radius_m=0.1,
    separation_m=0.1,
    goal=Point(x_m=6.0, y_m=0.0),
    goal_tolerance_m=0.1,
    directions=360,
)
ORDER = (1, 2, 3)
BEHIND_M = MISSION.robot_keep_m
POST: list[Shape] = [Circle(centre_m=(3.0, 0.1), radius_m=0.5)]


def queue(*, loss: float = 0.0, odd: float = 0.0, seed: int = 0, shapes: list[Shape] = POST) -> MemberStage:
    return MemberStage(MISSION, row(3), ORDER, shapes=shapes, loss=loss, odd=odd, seed=seed)


def time_to_the_goal_s(loss: float, seed: int) -> float:
    stage = queue(loss=loss, odd=loss / 2.0, seed=seed)
    stage.run(300.0)
    assert [robot for robot, record in stage.told if isinstance(record, RobotArrived)] == [1, 2, 3]
    return stage.now_s


# --- driving --------------------------------------------------------------------------------------------


def test_a_queue_drives_to_the_goal_in_its_order() -> None:
    stage = queue()
    stage.run(60.0)
    assert [robot for robot, record in stage.told if isinstance(record, RobotArrived)] == [1, 2, 3]
    assert sorted(record.rank for record in stage.records(StrandJoined)) == [0, 1, 2]
    assert [body.x_m > 4.0 for body in stage.bodies.values()] == [True] * 3


@pytest.mark.parametrize(("loss", "times"), [(0.5, 1.1), (0.9, 4.0), *long([(0.75, 1.5)])])
def test_lost_messages_cost_little_time(loss: float, times: float) -> None:
    without_s = time_to_the_goal_s(0.0, 0)
    assert sorted(time_to_the_goal_s(loss, seed) for seed in range(5))[2] <= times * without_s


def test_a_robot_drives_on_its_authority_though_its_link_is_silent() -> None:
    stage = queue()
    stage.run(3.0)
    before_m, stage.cut_off = stage.members[3].progress_m, {3}
    stage.run(MISSION.silence_s + 2.0)
    assert [link.silent for link in stage.members[3].strand.links] == [True]
    stands_m = stage.members[3].progress_m
    assert stands_m > before_m + 0.05
    stage.run(5.0)
    assert stage.members[3].progress_m == stands_m, "no news is no more motion"


def test_a_leader_that_hears_nobody_stops_when_the_strand_is_stretched() -> None:
    """V10 of the schedules: the formation is lost to the robot behind, and the leader drives on."""
    stage = queue()
    stage.cut_off = {1}
    stage.run(30.0)
    assert stage.records(RobotHeld)
    stretch_m = MISSION.link_length_m_max + BEHIND_M
    behind_m = stage.members[2].formation.s_m
    assert 0.5 < stage.leader.progress_m - behind_m < stretch_m + 2.0 * MISSION.speed_mps * PERIOD_S + 0.06


def test_a_follower_that_was_never_heard_gets_nothing_from_another_life_of_the_robot_ahead() -> None:
    """V2: the leader plans, tells the robot behind, and dies; its second life plans other ground."""
    stage = queue(shapes=[])
    stage.wake(1)
    follower, first = stage.members[2], stage.newest_ahead(1)
    stage.sent.clear()
    stage.give(2, LinkHeard(1, 50, first))
    known = len(follower.path)
    elsewhere = Vertex(x_m=first.path[-1].x_m, y_m=9.0, s_m=first.path[-1].s_m + 9.0)
    of_another_life = replace(
        first,
        life=first.life + 1,
        path_from=known,
        path=(elsewhere,),
        vertices=known + 1,
        progress_m=9.0,
        authority_m=9.0,
    )
    assert [each for each in stage.give(2, LinkHeard(1, 51, of_another_life)) if isinstance(each, Note)] == []
    assert len(follower.path) == known
    stage.run(5.0)
    assert follower.progress_m < 9.0


def test_after_a_clear_check_a_robot_drives_in_the_same_event() -> None:
    stage = queue(shapes=[])
    follower, part = stage.members[2], stage.parts[2]
    stage.wake(1)
    stage.wake(2)
    state = stage.newest_ahead(1)
    asked = follower.hear(LinkHeard(1, 50, replace(state, authority_m=state.progress_m - BEHIND_M)), 0.2)
    asked += follower.act(0.2)
    assert [command for command in asked if isinstance(command, AskScan)]
    before = part.driver.drive
    part.senses.hear(stage.scan(2))
    noted = [command.record for command in follower.act(0.2) if isinstance(command, Note)]
    assert [record.clear for record in noted if isinstance(record, SegmentChecked)] == [True]
    assert (before.target, part.driver.drive.target is None) == (None, False)
    assert part.driver.drive.bearing.epoch == follower.formation.epoch


# --- places ---------------------------------------------------------------------------------------------


@pytest.mark.parametrize(("off_m", "fits"), [(0.9 * MISSION.mu0_m, True), (1.1 * MISSION.mu0_m, False)])
def test_a_robot_that_does_not_stand_at_its_place_does_nothing_but_want_a_view(
    off_m: float, *, fits: bool
) -> None:
    stage = queue(shapes=[])
    told = stage.leader.formation
    member = stage.join(1, replace(told, place=replace(told.place, y_m=off_m)), stage.leader.path)
    commands = stage.wake(1)
    assert bool(commands) is fits
    assert (member.reason is None) is fits
    assert fits or (member.reason is not None and member.reason.cause is Cause.MISFIT)
    assert (stage.parts[1].driver.drive.target is not None) is fits


@pytest.mark.parametrize(("off_m", "plans"), [(0.9 * MISSION.mu0_m, True), (1.1 * MISSION.mu0_m, False)])
def test_a_leader_that_stands_off_the_end_of_its_path_asks_for_no_scan_but_wants_a_view(
    off_m: float, *, plans: bool
) -> None:
    stage = queue(shapes=[])
    *others, end = (Point(x_m=each.x_m, y_m=each.y_m) for each in stage.leader.path)
    path = Path([*others, replace(end, y_m=end.y_m + off_m)])
    member = stage.join(1, stage.leader.formation, path)
    commands = stage.wake(1)
    assert any(isinstance(each, AskScan) for each in commands) is plans
    assert (member.reason is None) is plans
    assert plans or (member.reason is not None and member.reason.cause is Cause.MISFIT)


@pytest.mark.parametrize(("off_m", "granted"), [(-0.9 * MISSION.mu0_m, False), (0.02, True)])
def test_a_leader_that_began_too_near_to_something_grants_nothing(off_m: float, *, granted: bool) -> None:
    """Rule 5 of `leading.py`: when it has gone on, it wants a view, in which others find their own places."""
    beside_m = MISSION.robot_radius_m + MISSION.clear_m + off_m + 0.1
    stage = queue(shapes=[Circle(centre_m=(0.0, beside_m), radius_m=0.1)])
    stage.run(30.0)
    assert (stage.leader.strand.grants.granted_m > stage.leader.formation.s_m) is granted
    assert stage.leader.progress_m > stage.leader.formation.s_m + 0.5
    reason = stage.leader.reason
    assert granted or (reason is not None and reason.cause is Cause.MISFIT)


def test_a_leader_that_began_too_near_to_something_and_arrives_there_lets_others_come_up_to_it() -> None:
    here = replace(MISSION, goal=Point(x_m=0.0, y_m=0.0))
    stage = MemberStage(here, row(3, spacing_m=here.grant_keep_m + 0.9 * GRANT_M_MIN), ORDER)
    stage.leader.strand.grants.withhold(too_near=True)
    stage.run(30.0)
    assert [robot for robot, record in stage.told if isinstance(record, RobotArrived)] == [1, 2, 3]
    apart_m = [one.progress_m - other.progress_m for one, other in pairwise(stage.members.values())]
    assert apart_m == [pytest.approx(here.grant_keep_m)] * 2


def test_under_another_fence_than_the_formations_a_member_does_nothing() -> None:
    stage = queue(shapes=[])
    stage.run(1.0)
    stage.stop()
    stage.now_s += MISSION.heartbeat_s
    assert [stage.wake(robot) for robot in ORDER] == [[], [], []]
    assert all(part.driver.standing for part in stage.parts.values())


def test_the_leader_says_whom_it_succeeds_and_that_the_strand_has_healed() -> None:
    stage = queue(shapes=[])
    for led_by, heals, successions in ((0, False, 0), (1, True, 0), (2, True, 1)):
        stage.told.clear()
        told = replace(stage.leader.formation, led_by=led_by, heals=heals)
        stage.join(1, told, stage.leader.path.copy())
        stage.wake(1)
        stage.wake(1)
        assert len(stage.records(LeaderSucceeded)) == successions
        assert [record.robots for record in stage.records(StrandHealed)] == [3] * heals
        assert len(stage.records(StrandJoined)) == 1


# --- what a member wants --------------------------------------------------------------------------------

BOX = Circle(centre_m=(-0.25, 0.0), radius_m=0.1)  # between robots 1 and 2


def test_a_robot_whose_way_stays_blocked_wants_a_view_until_the_block_goes_away() -> None:
    stage = queue(shapes=[])
    stage.shapes, stage.is_checked = [BOX], False
    stage.run(BLOCKED_S - 1.0)
    early = stage.members[2].reason
    stage.run(2.0)
    reason, counters = stage.members[2].reason, stage.members[2].counters
    assert (early, reason is not None and (reason.cause, reason.about)) == (None, (Cause.BLOCKED, 2))
    assert counters.in_vain == 1
    assert not stage.parts[2].driver.was_sent, "it stands"
    stage.shapes = []
    stage.run(2.0)
    assert (stage.members[2].reason, stage.members[2].counters.in_vain) == (None, 0)
    assert stage.parts[2].driver.was_sent


@pytest.mark.parametrize(
    ("in_vain", "heals", "cause"),
    [((), 1, Cause.NO_WAY), ((3, 2), 1, Cause.NO_WAY), ((1, 3, 2), 1, None), ((), 0, None)],
)
def test_a_leader_that_knows_no_way_on_after_a_loss_wants_another_to_lead_unless_it_led_before(
    in_vain: tuple[int, ...], heals: int, cause: Cause | None
) -> None:
    mission = replace(MISSION, law="printed")  # without two obstacles in sight, this law knows no way
    stage = MemberStage(mission, row(3), ORDER, counters=Counters(steps=4, last_to_lead=in_vain, heals=heals))
    stage.run(10.0)
    reason, counters = stage.leader.reason, stage.leader.counters
    assert (None if reason is None else reason.cause) == cause
    assert len(stage.records(RouteLost)) == (cause is None)
    wanted = cause is not None
    assert (counters.in_vain, counters.last_to_lead) == (wanted, (*in_vain, 1) if wanted else in_vain)


def test_a_leader_that_was_told_one_robot_many_times_tells_no_more_robots_than_a_message_has_room_for() -> (
    None
):
    told = Counters(last_to_lead=(2,) * ROBOTS_MAX, heals=1)
    stage = MemberStage(replace(MISSION, law="printed"), row(3), ORDER, counters=told)
    stage.run(10.0)
    assert stage.leader.counters.last_to_lead == (2, 1)


@pytest.mark.parametrize(
    ("in_vain", "wants", "lost_after_s"), [((), True, None), ((1,), False, 20.0)], ids=["first", "again"]
)
def test_a_leader_without_a_way_hands_on_at_once_but_loses_the_route_only_when_all_have_stood_for_long(
    in_vain: tuple[int, ...], lost_after_s: float | None, *, wants: bool, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(Leader, "plan", lambda *_, **__: NO_WAY)
    counters = Counters(last_to_lead=in_vain, heals=1)
    stage = MemberStage(replace(MISSION, robots=4), row(3), ORDER, counters=counters)
    stage.run(2.0)
    assert (stage.leader.reason is not None) == wants
    assert not stage.records(RouteLost), "a robot that is left out may come back"
    stage.run(lost_after_s or 0.0)
    assert len(stage.records(RouteLost)) == (lost_after_s is not None)


@pytest.mark.parametrize("step", [NO_WAY, Wait()])
def test_a_leader_without_a_way_lets_those_lead_that_have_not_led_in_vain(
    step: NoStep | Wait, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(Leader, "plan", lambda *_, **__: step)
    counters = Counters(last_to_lead=(6, 1, 5), heals=1)
    stage = MemberStage(replace(MISSION, robots=6), row(3), ORDER, counters=counters)
    assert not stage.leader.lets_lead(4), "it has not looked yet"
    stage.run(2.0)
    assert [robot for robot in (4, 5, 6) if stage.leader.lets_lead(robot)] == ([4] if step == NO_WAY else [])
    assert not stage.members[2].lets_lead(4), "it does not lead"


@pytest.mark.parametrize("heals", [0, 1])
def test_after_a_loss_a_leader_counts_with_traces_of_bodies_in_its_map(
    heals: int, monkeypatch: pytest.MonkeyPatch
) -> None:
    asked: list[bool] = []

    def planned(*_: object, bodies_may_move: bool, **__: object) -> NoStep:
        asked.append(bodies_may_move)
        return NoStep("a test")

    monkeypatch.setattr(Leader, "plan", planned)
    stage = MemberStage(MISSION, row(3), ORDER, counters=Counters(heals=heals))
    stage.run(1.0)
    assert set(asked) == {heals > 0}


@pytest.mark.parametrize(
    ("in_vain", "back_by_m", "may_forget"), [((), 0.0, True), ((2,), 0.0, False), ((2,), 0.4, True)]
)
def test_a_map_may_be_cleared_but_where_only_the_leader_has_changed(
    in_vain: tuple[int, ...], back_by_m: float, *, may_forget: bool, monkeypatch: pytest.MonkeyPatch
) -> None:
    asked: list[bool] = []

    def planned(*_: object, may_forget: bool, **__: object) -> NoStep:
        asked.append(may_forget)
        return NO_WAY

    monkeypatch.setattr(Leader, "plan", planned)
    stage = MemberStage(MISSION, row(3), ORDER, counters=Counters(last_to_lead=in_vain, heals=1))
    stage.form(stage.leader.path, {3: 0.0, 2: 0.5, 1: 1.0}, back_by_m=back_by_m)
    stage.run(10.0)
    assert asked[-1] is may_forget


@pytest.mark.parametrize(("has_forgotten", "cause"), [(False, Cause.DEAD_END), (True, Cause.NO_WAY)])
def test_a_tail_that_leads_does_not_turn_the_strand_round_again_on_a_cleared_map(
    has_forgotten: bool, cause: Cause, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(Leader, "plan", lambda *_, **__: DeadEnd(0.0))
    monkeypatch.setattr(Leader, "make_room", lambda *_, **__: DeadEnd(0.0))
    monkeypatch.setattr(Leader, "has_forgotten", has_forgotten)
    stage = MemberStage(replace(MISSION, robots=4), row(3), ORDER)
    stage.form(stage.leader.path, {3: 0.0, 2: 0.5, 1: 1.0}, back_by_m=0.4)
    stage.run(30.0)
    reason = stage.leader.reason
    assert reason is not None
    assert reason.cause is cause


# --- turning round --------------------------------------------------------------------------------------


def pocket() -> list[Shape]:
    """A blind alley, too narrow for two robots side by side."""
    low, high = wall((0.0, -0.37), (3.0, -0.37), thick_m=-0.02), wall((0.0, 0.35), (3.0, 0.35))
    return [low, high, wall((3.0, -0.37), (3.0, 0.37), thick_m=-0.02)]


def in_the_pocket(*, loss: float = 0.0) -> MemberStage:
    mission = replace(MISSION, directions=720, range_m_max=1.5)
    return MemberStage(
        mission,
        row(3, x_m=0.3),
        ORDER,
        shapes=pocket(),
        loss=loss,
        odd=loss / 2.0,
    )


@pytest.mark.parametrize("loss", [0.0, 0.5])
def test_a_strand_in_a_blind_alley_turns_round_and_comes_to_the_goal(loss: float) -> None:
    stage = in_the_pocket(loss=loss)
    stage.run(12.0)
    reason = stage.leader.reason
    assert reason is not None
    tail_m = stage.members[3].progress_m
    assert reason.cause is Cause.DEAD_END
    assert reason.turnabout == Turnabout(cut_m=tail_m, end_m=stage.leader.progress_m, back_by_m=0.0)
    assert stage.leader.counters.in_vain == 1
    stage.run(100.0, turns=True)
    assert all(member.arrived for member in stage.members.values())
    assert stage.order == (3, 2, 1)
    assert stage.leader.counters.in_vain == 0, "a step towards the goal was planned"


def test_a_leader_that_waits_for_its_strand_plans_again_as_soon_as_all_have_stood_for_a_while(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setattr(Leader, "plan", lambda *_, settled, **__: DeadEnd(0.4) if settled else Wait())
    stage = MemberStage(MISSION, row(3), ORDER)
    while stage.leader.strand.quiet_s < SETTLED_S:
        assert stage.leader.reason is None
        stage.run(0.1)
    stage.run(0.1)
    assert stage.leader.reason is not None, "it does not wait for as long again"


def test_a_robot_in_whose_way_the_ones_behind_stand_wants_the_strand_to_dissolve() -> None:
    corners = [(0.16, -0.29), (0.0, 0.0), (0.31, -0.11), (1.34, 0.75)]  # the third passes the first too near
    at = dict(zip((3, 2, 1), (corners[0], corners[1], corners[3]), strict=True))
    places = {robot: Pose(x_m=x_m, y_m=y_m, heading_rad=0.0) for robot, (x_m, y_m) in at.items()}
    stage = MemberStage(MISSION, places, ORDER)
    path = Path(Point(x_m=x_m, y_m=y_m) for x_m, y_m in corners)
    stage.form(path, {3: 0.0, 2: path[1].s_m, 1: path.end_m}, driven=True)
    stage.run(3.0 * BLOCKED_S)
    reason = stage.members[2].reason
    assert reason is not None
    assert reason.cause is Cause.BLOCKED
