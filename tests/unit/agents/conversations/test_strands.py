"""Strands that form, lose robots and form again. Each test is a schedule of the design."""

import math

import pytest
from msgspec.structs import replace

from agents.coordinating.phases import Phase
from agents.membership import reporting
from agents.membership.joining import Joining
from agents.membership.states import State
from agents.navigation.step import NoStep
from agents.strand.leader import NO_WAY, Leader
from agents.strand.leading import Leading
from agents.strand.member import Member
from clew.explore.setting import SCATTERED, SETTINGS, Setting
from protocol.fence import Cause, Epoch, May, Raise
from protocol.frames import Pose
from protocol.timeline import (
    FenceChanged,
    RobotHeld,
    RobotStranded,
    SegmentChecked,
    StrandReversed,
    ViewProposed,
)
from protocol.wire.messages import AheadState, BehindState, Drive, Odometry, Scan
from protocol.wire.view import Answer, Formation, Plea, Report
from tests.support.stages.view_stage import Post, ViewStage, of

STATES = (AheadState, BehindState)
U_SHAPED = ((1.6, 2.2, 0.0), (0.8, 2.2, 0.0), (0.4, 1.5, 0.0), (0.8, 0.8, 0.0), (1.6, 0.8, 0.0))


def moves(post: Post) -> bool:
    """Whether a letter is an order to move."""
    return isinstance(post.thing, Drive) and post.thing.target is not None


def cut(stage: ViewStage, robot: int) -> None:
    """From now on, all letters to and from a robot are lost."""
    stage.lose(lambda post: robot in (post.sender, post.receiver))


def keep_silent(stage: ViewStage) -> None:
    """Nobody's raise arrives any more."""
    stage.lose(of(Raise))


def test_v2_a_new_life_takes_no_part_in_the_formation_of_its_former_life() -> None:
    stage = ViewStage.begun()
    stage.raised_by(3)
    stage.run(lambda: stage.moving() == {1, 2, 3})
    epoch = stage.fence.epoch
    pieces = stage.sent(of(Formation, receiver=1))
    keep_silent(stage)
    stage.replace(1)
    first = len(stage.posted)
    stage.post(*pieces)
    stage.pass_s(3.0)
    assert stage.fence.epoch == epoch
    assert not [post for post in stage.posted[first:] if post.sender == 1 and moves(post)]
    assert not [post for post in stage.posted[first:] if of(STATES, sender=1)(post)]
    assert stage.processes[1].robot.state is not State.MEMBER
    stage.heal()
    stage.run(lambda: stage.fence.epoch != epoch and stage.fence.may is May.ALL)


def test_v2_a_view_goes_on_with_the_new_life_of_a_robot_that_has_reported() -> None:
    """It stands where its former life stood: nobody has had a turn."""
    stage = ViewStage.begun()
    stage.raised_by(3)
    stage.run(lambda: stage.processes[3].robot.phase is Phase.LOOKING)
    epoch = stage.fence.epoch
    stage.replace(2)
    stage.run(lambda: stage.fence.may is May.ALL)
    assert stage.fence.epoch == epoch
    assert stage.formed is not None
    assert dict(zip(stage.formed.order, stage.formed.lives, strict=True))[2] == f"{stage.lives[2]:x}"
    stage.run(lambda: stage.moving() == {1, 2, 3})


def test_v2_nothing_is_taken_from_a_link_state_of_another_life() -> None:
    stage = ViewStage.driving()
    stage.run(lambda: stage.moving() == {1, 2, 3})
    keep_silent(stage)
    real = stage.sent(of(AheadState, sender=1, receiver=2))[-1]
    stage.kill(1)
    wide = replace(real.thing, life=real.thing.life + 1, authority_m=real.thing.progress_m)
    stage.run(lambda: 2 not in stage.moving())
    at = stage.place(2)
    stage.post(real._replace(number=real.number + 100, thing=wide))
    stage.pass_s(2.0)
    assert stage.place(2) == at


def test_v3_a_robot_that_died_on_a_leg_is_no_robot_ahead() -> None:
    stage = ViewStage.driving(((1.6, 1.5, 0.0), (0.7, 1.5, 0.0), (0.3, 1.5, 0.0)))
    stage.run(lambda: stage.moving() == {1, 2, 3})
    stage.kill(3)
    stage.run(lambda: stage.fence.epoch.generation == 2)
    (x_1, y_1), (x_2, y_2) = stage.place(1), stage.place(2)
    stage.push(3, (x_1 + x_2) / 2, (y_1 + y_2) / 2)  # it has crossed their leg in its turn, and died there
    stage.run(lambda: stage.fence.may is May.ALL)
    assert stage.formed is not None
    since_s = stage.now_s
    stage.run(lambda: bool(stage.records_of(SegmentChecked, 2, since_s=since_s)), s_max=20.0)
    assert not stage.records_of(SegmentChecked, 2, since_s=since_s)[0].clear
    stage.pass_s(20.0)
    assert stage.apart_m(2, 3) >= 0.25


def test_v8_a_raise_of_the_same_generation_that_arrives_late_stops_no_strand() -> None:
    stage = ViewStage.begun()
    stage.raised_by(1)
    late = Raise(epoch=Epoch(generation=1, robot=3, life=stage.lives[3]), cause=Cause.START)
    stage.run(lambda: stage.moving() == {1, 2, 3})
    fence = stage.fence
    stage.deliver(Post(3, 0, 0, late))
    assert (stage.fence, stage.moving()) == (fence, {1, 2, 3})


def test_v10_a_leader_that_hears_nobody_stands_when_the_strand_is_stretched() -> None:
    stage = ViewStage.begun()
    stage.raised_by(3)
    stage.lose(of(Formation, receiver=2))
    stage.run(lambda: stage.fence.may is May.ALL)
    keep_silent(stage)
    stage.kill(3)
    stage.pass_s(15.0)
    assert stage.records_of(RobotHeld, 1)
    assert stage.moving() == set()
    assert stage.apart_m(1, 2) <= stage.scenario.fleet.link_length_m_max + 0.5


def test_v12_a_member_that_does_not_stand_at_its_place_says_nothing_and_raises() -> None:
    stage = ViewStage.begun()
    stage.raised_by(3)
    stage.run(lambda: stage.formed is not None)
    stage.hold(of(Odometry, receiver=2))
    stage.run(lambda: stage.fence.may is May.ALL)
    epoch = stage.fence.epoch
    x_m, y_m = stage.place(2)
    stage.push(2, x_m, y_m + 0.05)
    stage.run(lambda: any(post.thing.pose.y_m > y_m for post in stage.held))
    stage.mail += stage.forget()[-1:]
    first = len(stage.posted)
    stage.run(lambda: stage.fence.epoch != epoch)
    said = [post for post in stage.posted[first:] if post.sender == 2]
    assert not [post for post in said if isinstance(post.thing, STATES) or moves(post)]
    assert stage.records_of(ViewProposed, 2)[-1].cause is Cause.MISFIT
    stage.run(lambda: stage.fence.may is May.ALL)


def test_v12_all_members_have_the_arc_lengths_that_the_formation_tells() -> None:
    stage = ViewStage.begun(U_SHAPED)
    stage.raised_by(3)
    stage.run(lambda: stage.fence.may is May.ALL)
    pieces = [post.thing for post in stage.sent(of(Formation))]
    assert len({piece.path for piece in pieces}) == 1
    told = {piece.ahead.robot: piece.ahead.s_m for piece in pieces if piece.ahead is not None}
    told |= {piece.behind.robot: piece.behind.s_m for piece in pieces if piece.behind is not None}
    assert stage.formed is not None
    noted = dict(zip(stage.formed.order, stage.formed.places_m, strict=True))
    assert told == noted
    assert {piece.s_m for piece in pieces} == {noted[robot] for robot in noted if robot != 3}


@pytest.mark.parametrize("separation_m", [0.05, 0.2])
def test_v13_robots_that_are_left_out_are_passed_at_the_greater_of_epsilon_and_the_separation(
    separation_m: float,
) -> None:
    places = ((1.2, 1.2, 0.0), (0.7, 1.2, 0.0), (2.4, 1.42, 0.0))
    scenario = Setting(name="passed", about="a robot beside the way", places=places).scenario()
    scenario = replace(scenario, fleet=replace(scenario.fleet, separation_m=separation_m))
    stage = ViewStage.begun(places, scenario)
    stage.kill(3)
    stage.run(lambda: stage.fence.may is May.ALL)
    stage.pass_s(20.0)
    x_m = max(stage.place(1)[0], stage.place(2)[0])
    keep_m = 2 * scenario.fleet.robot_radius_m + max(scenario.law.epsilon_m, separation_m)
    assert x_m > 2.4, "it has passed the robot that is left out"
    passed_m = min(
        math.dist((sample.x_m, sample.y_m), stage.place(3))
        for robot in (1, 2)
        for sample in _samples(stage, robot)
    )
    assert passed_m >= keep_m - scenario.law.mu0_m


def test_a_body_on_a_driven_leg_that_is_longer_than_scans_reach_is_not_driven_over() -> None:
    """A robot that is left out died as it crossed the leg, 1.9 m ahead of the robot whose leg that is."""
    places = ((1.9, 1.2, 0.0), (0.5, 1.2, 0.0), (1.2, 2.2, 0.0))
    scenario = Setting(
        name="far", about="a long leg", places=places, goal_m=(3.15, 1.2), obstacles=(), link_length_m_max=3.0
    ).scenario()
    scenario = replace(scenario, sensor=replace(scenario.sensor, range_m_max=1.5))
    stage = ViewStage.begun(places, scenario)
    stage.kill(3)
    stage.lose(lambda post: post.sender == 2 and moves(post))
    stage.run(lambda: stage.place(1)[0] > 2.9)
    stage.resume_world()
    stage.push(3, 2.4, 1.2)
    stage.heal()
    stage.run(lambda: stage.fence.may is May.ALL)
    stage.pass_s(5.0)
    assert 1.0 < stage.place(2)[0] < 2.4 - 2.0 * scenario.fleet.robot_radius_m - scenario.fleet.separation_m


def _samples(stage: ViewStage, robot: int) -> list[Pose]:
    return [post.thing.pose for post in stage.sent(of(Odometry, receiver=robot))]


def test_v14_a_robot_that_was_cut_off_while_a_view_formed_moves_no_body_by_what_it_remembers() -> None:
    stage = ViewStage.driving()
    stage.run(lambda: stage.moving() == {1, 2, 3})
    cut(stage, 3)
    old = stage.sent(of(Drive, sender=3))[-1].thing
    epoch = stage.fence.epoch
    stage.run(lambda: stage.fence.epoch != epoch and stage.fence.may is May.ALL)
    state = stage.sent(of(AheadState, receiver=3))[-1]
    stage.heal()
    stage.lose(of(Odometry, receiver=3))  # it does not know of the new view
    late = replace(old, number=old.number + 1, basis_s=stage.now_s)
    stage.post(state._replace(number=state.number + 1000), Post(3, 0, 0, late))
    stage.run(lambda: not stage.mail)
    assert 3 not in stage.moving()
    stage.heal()
    stage.run(lambda: stage.processes[3].robot.state is not State.MEMBER, s_max=1.0)


def test_v21_every_member_is_told_the_whole_path() -> None:
    stage = ViewStage.begun(U_SHAPED)
    stage.raised_by(3)
    stage.run(lambda: stage.fence.may is May.ALL)
    assert stage.formed is not None
    for robot in set(stage.formed.order) - {3}:  # which tells itself without a letter
        corners = [vertex for piece in _pieces(stage, robot) for vertex in piece.path]
        assert [(corner.x_m, corner.y_m) for corner in corners] == [
            (point.x_m, point.y_m) for point in stage.formed.laid
        ]
    stage.pass_s(15.0)


def _pieces(stage: ViewStage, robot: int) -> list[Formation]:
    pieces = {post.thing.first: post.thing for post in stage.sent(of(Formation, receiver=robot))}
    return [pieces[first] for first in sorted(pieces)]


def test_a_formation_that_is_lost_is_sent_again_byte_for_byte() -> None:
    stage = ViewStage.begun()
    stage.raised_by(3)
    stage.lose(of(Formation, receiver=2))
    stage.run(lambda: stage.fence.may is May.ALL)
    stage.pass_s(1.0)
    stage.heal()
    stage.run(lambda: stage.processes[2].robot.state is State.MEMBER, s_max=1.0)
    assert len({post.thing for post in stage.sent(of(Formation, receiver=2))}) == 1
    assert len(stage.sent(of(Formation, receiver=2))) > 1


def test_a_robot_that_reports_too_late_is_left_out_and_let_in_by_its_plea() -> None:
    stage = ViewStage.begun()
    stage.raised_by(1)
    stage.lose(of((Report, Odometry), sender=3))
    cut(stage, 3)
    stage.run(lambda: stage.fence.may is May.ALL, s_max=10.0)
    assert stage.formed is not None
    assert set(stage.formed.order) == {1, 2}
    stage.heal()
    stage.run(lambda: stage.fence.members == 3, s_max=40.0)
    causes = [change.cause for change in stage.records_of(FenceChanged) if change.cause is not None]
    assert Cause.PLEA in causes
    assert any(post.thing.out for post in stage.sent(of(Answer, receiver=3)))


def test_a_robot_that_was_started_again_asks_to_be_let_in_as_soon_as_it_is_left_out() -> None:
    stage = ViewStage.driving()
    stage.kill(3)
    stage.run(lambda: stage.fence.may is May.ALL and stage.fence.members == 2)
    stage.start(3)
    stage.run(lambda: bool(stage.sent(of(Plea, sender=3))), s_max=1.0)


def test_a_robot_that_comes_back_in_a_dead_end_is_let_in_before_the_strand_has_come_out() -> None:
    stage = ViewStage.driving(SETTINGS["round"].places, SETTINGS["round"].scenario())
    stage.kill(3)
    stage.run(lambda: stage.fence.may is May.ALL and stage.fence.members == 2)
    stage.lose(of(Plea))
    stage.start(3)
    stage.run(lambda: bool(stage.records_of(StrandReversed)), s_max=30.0)
    stage.heal()
    stage.run(lambda: stage.fence.may is May.ALL and stage.fence.members == 3, s_max=6.0)
    assert not stage.records_of(RobotStranded)


@pytest.mark.parametrize("may_lead", [False, True])
def test_a_robot_that_found_no_way_to_a_strand_that_stands_is_let_in_again_only_if_it_may_lead(
    monkeypatch: pytest.MonkeyPatch, *, may_lead: bool
) -> None:
    """Found in front of a pocket in which a strand was locked: the one outside could have led on alone."""
    stage = ViewStage.driving()
    stage.kill(3)
    stage.run(lambda: stage.fence.may is May.ALL and stage.fence.members == 2)
    monkeypatch.setattr(Leader, "plan", lambda *_, **__: NO_WAY)
    monkeypatch.setattr(Member, "lets_lead", lambda *_: may_lead)
    monkeypatch.setattr(Leading, "_give_up_lead", lambda *_: [])  # it wants no other to lead
    monkeypatch.setattr(reporting, "leg_is_clear", lambda *_: False)
    monkeypatch.setattr(Joining, "plan", lambda *_: NoStep("a test"))
    epoch = stage.fence.epoch
    stage.start(3)
    stage.run(lambda: bool(stage.records_of(RobotStranded)))
    stage.pass_s(4.0)
    causes = [each.cause for each in stage.records_of(ViewProposed, 1) if each.epoch > epoch.number]
    assert causes == [Cause.PLEA] * (1 + may_lead)


def test_a_raise_that_was_lost_for_another_reason_does_not_keep_a_strand_from_turning_round() -> None:
    """Both are for the same epoch: none has begun between them."""
    stage = ViewStage.begun(SETTINGS["round"].places, SETTINGS["round"].scenario())
    stage.raised_by(3)
    stage.lose(of((Answer, Raise)))
    stage.lose(of(Scan, receiver=2))  # the view waits for its look
    stage.run(lambda: stage.records_of(ViewProposed, 1)[-1].cause is Cause.COORDINATOR_LOST)
    stage.heal()
    keep_silent(stage)
    stage.run(lambda: stage.fence.may is May.ALL)
    stage.heal()
    assert (stage.fence.epoch.generation, stage.fence.robot) == (1, 1)
    stage.run(lambda: stage.fence.epoch.generation == 2, s_max=30.0)
    assert [each.cause for each in stage.records_of(ViewProposed, 1)][-1] is Cause.DEAD_END
    assert len(stage.records_of(StrandReversed, 1)) == 1
    stage.run(lambda: stage.fence.may is May.ALL)
    assert stage.formed is not None
    assert stage.formed.order == (3, 2, 1)


def test_a_robot_that_does_not_count_for_now_goes_on_reporting_until_the_formation_leaves_it_out() -> None:
    stage = ViewStage.driving()
    stage.lose(lambda post: isinstance(post.thing, STATES) and {post.sender, post.receiver} == {2, 3})
    stage.lose(of(Raise, sender=3))
    former = stage.fence.epoch
    stage.run(lambda: stage.fence.epoch != former)
    stage.lose(of(Odometry, receiver=1))  # the view waits for its report
    first = len(stage.posted)
    stage.run(lambda: bool(stage.formed))
    told = [post.thing for post in stage.posted[first:] if of(Answer, receiver=3)(post)]
    assert told
    assert not any(answer.out for answer in told)
    assert stage.processes[3].robot.state is State.BOUND
    stage.run(lambda: stage.processes[3].robot.state is State.ASIDE, s_max=2.0)


def test_a_strand_of_scattered_robots_comes_to_the_goal() -> None:
    stage = ViewStage.driving(SCATTERED)
    stage.run(lambda: math.dist(stage.place(1), (3.4, 1.5)) < 0.2, s_max=40.0)


def test_a_leader_that_lives_but_hears_too_little_to_drive_is_succeeded() -> None:
    stage = ViewStage.begun()
    stage.lose(of(Scan, receiver=1))
    stage.raised_by(2)
    stage.run(lambda: stage.fence.may is May.ALL)
    stage.lose(lambda post: post.receiver == 1 and stage.now_s % 3.5 > 0.3)
    stage.run(lambda: stage.formed is not None and stage.formed.order == (2, 3), s_max=40.0)
