"""Turns: what is late, repeated or of another life moves no body. Each test is a schedule of the design."""

import pytest
from msgspec.structs import replace

from agents.coordinating import coordinator
from agents.coordinating.agreeing import NO_ROOM
from agents.membership.states import State
from clew.explore.setting import SCATTERED
from protocol.fence import May, Raise, Turn
from protocol.timeline import FenceChanged, OrderAccepted, OrderRefused, RobotPlaced, RobotStranded
from protocol.wire.messages import Drive, Odometry, Scan
from protocol.wire.view import Answer, Formation, Report
from tests.support.stages.view_stage import Post, ViewStage, in_turn, of

FAR = ((1.6, 1.5, 0.0), (0.4, 0.5, 0.0), (0.4, 2.5, 0.0))
"""Robot 1 leads; robots 2 and 3 have a turn each."""


def drives_after(stage: ViewStage, robot: int, first: int) -> list[Post]:
    """The orders to move that a robot has sent since."""
    return [
        post
        for post in stage.posted[first:]
        if of(Drive, sender=robot)(post) and post.thing.target is not None
    ]


def test_v1_a_coordinator_that_is_started_again_coordinates_nothing_in_the_epoch_of_its_former_life() -> None:
    stage = in_turn(2, 3, SCATTERED)
    epoch, old = stage.fence.epoch, stage.sent(of(Report, sender=3))[-1]
    stage.replace(2)
    first = len(stage.posted)
    stage.post(old)
    stage.run(lambda: stage.fence.epoch != epoch)
    said = [post for post in stage.posted[first:] if post.sender == 2 and _is_of(post, epoch)]
    assert not [post for post in said if isinstance(post.thing, Turn | Answer | Formation)]
    stage.run(lambda: stage.fence.may is May.ALL)


def _is_of(post: Post, epoch: object) -> bool:
    thing = post.thing.fence if isinstance(post.thing, Turn) else post.thing
    return getattr(thing, "epoch", None) == epoch


def test_v5_an_order_that_arrives_after_its_turn_moves_no_body() -> None:
    stage = ViewStage.begun(FAR)
    stage.raised_by(1)
    stage.hold(lambda post: isinstance(post.thing, Drive) and post.thing.target is not None)
    stage.run(lambda: bool(stage.held))
    late = stage.held[0]
    holder, turn = late.sender, stage.fence.turn
    stage.kill(holder)
    stage.run(lambda: stage.fence.turn > turn, s_max=0.9)  # later it is void for its age alone
    stage.release()
    stage.run(lambda: not stage.mail)
    assert not stage.records_of(OrderAccepted, since_s=stage.now_s - 0.2) or holder not in stage.moving()
    assert [refusal for refusal in stage.records_of(OrderRefused) if refusal.number == late.thing.number]
    stage.pass_s(1.0)
    assert holder not in stage.moving()


def test_v5_an_order_of_a_turn_moves_no_body_under_all() -> None:
    stage = in_turn(2, 3, SCATTERED)
    (late, *_) = drives_after(stage, 3, 0)
    stage.run(lambda: stage.fence.may is May.ALL)
    number = stage.world.bodies[2].ordered + 1
    stage.deliver(late._replace(thing=replace(late.thing, number=number, basis_s=stage.now_s)))
    assert 3 not in stage.moving()
    assert stage.records_of(OrderRefused)[-1].number == number


def test_v5_a_place_counts_only_when_it_was_told_after_the_robots_own_last_turn() -> None:
    stage = in_turn(2, 3, SCATTERED)
    turn = stage.fence.turn
    stage.lose(lambda post: of(Report, sender=3)(post) and post.thing.turn > turn)
    stage.run(lambda: bool(stage.records_of(RobotPlaced, 3)))
    stage.pass_s(2.0)
    assert (stage.formed, stage.fence.may) == (None, May.NOBODY)
    stage.heal()
    stage.run(lambda: stage.fence.may is May.ALL, s_max=2.0)


def test_a_robot_that_drives_in_its_turn_is_not_told_again_where_the_strand_ends() -> None:
    stage = in_turn(2, 3, SCATTERED)
    stage.run(lambda: not stage.mail)
    first = len(stage.posted)
    stage.pass_s(0.5)
    assert stage.moving() == {3}
    joins = [post for post in stage.posted[first:] if of(Answer, sender=2)(post) and post.thing.join]
    assert len(joins) <= 1, "the answer to its own report"


def test_v6_a_lease_that_arrives_after_all_gives_nobody_the_turn() -> None:
    stage = in_turn(2, 3, SCATTERED)
    lease = stage.sent(of(Turn, sender=2))[-1]
    told = next(
        post for post in reversed(stage.posted) if of(Odometry, receiver=3)(post) and post.thing.fence.turn
    )
    stage.run(lambda: stage.fence.may is May.ALL)
    stage.run(lambda: not stage.mail)
    fence = stage.fence
    stage.post(lease, told)
    stage.run(lambda: not stage.mail)
    assert stage.fence == fence
    assert stage.processes[3].robot.state is State.MEMBER
    stage.pass_s(5.0)


def test_a_report_of_an_older_epoch_does_not_count_however_high_its_number() -> None:
    stage = in_turn(2, 3, SCATTERED)
    stage.run(lambda: stage.fence.may is May.ALL)
    late = stage.sent(of(Report, sender=3))[-1]
    stage.pass_s(2.0)
    former = stage.fence.epoch
    stage.kill(1)
    stage.lose(of(Raise, sender=3))
    stage.run(lambda: stage.fence.epoch != former)
    epoch = stage.fence.epoch
    stage.run(lambda: bool(stage.sent(of(Report, sender=3, epoch=epoch))))
    (news, *_) = stage.sent(of(Report, sender=3, epoch=epoch))
    assert late.thing.number > news.thing.number
    assert late.thing.place != news.thing.place
    stage.post(late)
    stage.run(lambda: stage.fence.may is May.ALL, s_max=5.0)
    assert stage.fence.epoch == epoch
    assert stage.formed is not None
    assert set(stage.formed.order) == {2, 3}


def test_v16_an_old_report_ends_no_turn_that_was_given_later() -> None:
    stage = in_turn(1, 3, FAR)
    fence = stage.fence
    assert fence.turn == 2
    old = stage.sent(of(Report, sender=3))[-1]
    earlier = replace(old.thing, number=old.thing.number + 1, ended=fence.turn - 1, placed=True)
    stage.post(old, old._replace(thing=earlier))
    stage.run(lambda: not stage.mail)
    assert (stage.fence, stage.moving()) == (fence, {3})


def test_v16_a_robot_with_an_order_in_flight_reports_nothing_though_its_body_stands() -> None:
    stage = ViewStage.begun(SCATTERED)
    stage.raised_by(2)
    stage.hold(lambda post: of(Drive, sender=3)(post) and post.thing.target is not None)
    stage.run(lambda: bool(stage.held))
    first = len(stage.posted)
    stage.pass_s(0.8)
    told = [post.thing for post in stage.posted[first:] if of(Odometry, receiver=3)(post)]
    assert {odometry.moving for odometry in told} == {False}
    assert not [post for post in stage.posted[first:] if of(Report, sender=3)(post)]
    stage.release()
    stage.run(lambda: stage.fence.may is May.ALL, s_max=5.0)


def test_v17_a_robot_that_is_started_again_in_its_turn_does_not_take_the_turn_of_its_former_life() -> None:
    stage = in_turn(2, 3, SCATTERED)
    fence = stage.fence
    stage.replace(3)
    first = len(stage.posted)
    stage.run(lambda: stage.fence != fence)
    assert not drives_after(stage, 3, first)
    assert 3 not in stage.moving()
    stage.run(lambda: stage.fence.may is May.ALL)
    assert stage.formed is not None
    assert dict(zip(stage.formed.order, stage.formed.lives, strict=True))[3] == f"{stage.lives[3]:x}"


def test_v18_odometry_of_before_a_turn_that_arrives_late_brings_no_old_place_into_the_formation() -> None:
    stage = in_turn(2, 3, SCATTERED)
    old = next(
        post
        for post in stage.sent(of(Odometry, receiver=3))
        if (post.thing.fence.epoch, post.thing.fence.turn) == (stage.fence.epoch, 0)
    )
    turn = stage.fence.turn
    stage.hold(of(Turn, sender=2))
    stage.run(lambda: any(post.thing.ended == turn for post in stage.sent(of(Report, sender=3))))
    first = len(stage.posted)
    stage.deliver(old)
    stage.release()
    stage.run(lambda: stage.fence.may is May.ALL)
    told = [post.thing for post in stage.posted[first:] if of(Report, sender=3)(post)]
    assert {(report.place.x_m, report.place.y_m) for report in told} == {stage.place(3)}


def test_v19_one_number_of_a_turn_has_one_content_however_long_its_put_is_held_up() -> None:
    stage = ViewStage.begun(FAR)
    stage.raised_by(1)
    stage.hold(of(Turn, sender=1))
    stage.run(lambda: bool(stage.held))
    lease = stage.held[0].thing
    stage.kill(lease.fence.robot)
    stage.pass_s(3.0)
    assert {post.thing for post in stage.held} == {lease}
    stage.release()
    stage.run(lambda: stage.fence.may is May.ALL, s_max=200.0)
    contents = {(change.turn, change.may, change.named) for change in stage.records_of(FenceChanged)}
    assert len({turn for turn, _, _ in contents if turn}) == len([1 for turn, _, _ in contents if turn])


def test_v20_a_robot_that_dies_at_its_place_does_not_drive_on_in_its_next_life() -> None:
    stage = in_turn(2, 3, SCATTERED)
    turn = stage.fence.turn
    stage.hold(of(Turn, sender=2))
    stage.run(lambda: any(post.thing.ended == turn for post in stage.sent(of(Report, sender=3))))
    at = stage.place(3)
    stage.replace(3)
    first = len(stage.posted)
    stage.pass_s(0.3)
    assert (stage.fence.robot, stage.place(3), drives_after(stage, 3, first)) == (3, at, [])
    stage.release()
    stage.run(lambda: stage.fence.may is May.ALL)


def test_v20_all_never_follows_a_turn_that_names_a_robot() -> None:
    stage = ViewStage.driving(FAR)
    assert stage.fence.members == 3
    said = [change.may for change in stage.records_of(FenceChanged)]
    assert said.count(May.ONE) >= 2
    assert said[-2:] == [May.NOBODY, May.ALL]


def test_v4_a_scan_of_before_a_turn_shows_nobody_a_clear_leg() -> None:
    stage = ViewStage.begun(SCATTERED)
    stage.hold(of(Scan, receiver=2))
    stage.raised_by(1)
    stage.run(lambda: stage.fence.turn > 0, s_max=10.0)
    old = stage.held[-1]
    assert old.thing.fence.turn == 0
    stage.lose(lambda post: of(Scan, receiver=2)(post) and post.thing.fence != old.thing.fence)
    stage.release()
    first = len(stage.posted)
    stage.pass_s(0.5)
    assert not [post for post in stage.posted[first:] if of(Report, sender=2)(post) and post.thing.look]
    assert not drives_after(stage, 2, first)
    stage.heal()
    stage.run(lambda: stage.fence.may is May.ALL)


def test_a_strand_of_which_no_message_can_tell_goes_on_without_the_others_and_says_why(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setattr(coordinator, "fits", lambda part: len(part.strand) + len(part.line) <= 2)
    stage = ViewStage.begun(FAR)
    stage.run(lambda: stage.fence.may is May.ALL, s_max=120.0)
    assert stage.formed is not None
    assert len(stage.formed.order) == 2, "the second robot has a turn, the third none"
    assert {each.reason for each in stage.records_of(RobotStranded)} == {NO_ROOM}


def test_a_turn_is_taken_back_from_a_robot_that_stands_for_most_of_it_though_it_moves_now_and_then() -> None:
    stage = in_turn(1, 3, FAR)
    fence, began_s = stage.fence, stage.now_s
    stage.lose(lambda post: post.receiver == 3 and (stage.now_s - began_s) % 10.0 > 0.1)
    stage.run(lambda: stage.fence != fence, s_max=25.0)
    assert stage.fence.epoch == fence.epoch
    assert not [post for post in stage.sent(of(Report, sender=3)) if post.thing.ended == fence.turn]
