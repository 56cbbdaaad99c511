"""Worlds that are killed, stops and releases, and outsiders. Each test is a schedule of the design."""

import pytest

from agents.membership.states import State
from protocol.fence import Cause, May, Raise, Release, Stop
from protocol.timeline import FenceChanged, OrderRefused, ViewProposed
from protocol.wire.messages import Drive, Odometry
from tests.support.stages.view_stage import Post, ViewStage, of

OPERATOR = 0


def moves(post: Post) -> bool:
    """Whether a letter is an order to move."""
    return isinstance(post.thing, Drive) and post.thing.target is not None


def test_v7_a_world_that_is_killed_before_it_tells_a_fence_obeys_no_order_from_before() -> None:
    stage = ViewStage.driving()
    stage.run(lambda: stage.moving() == {1, 2, 3})
    orders = [stage.sent(of(Drive, sender=robot))[-1] for robot in stage.robots]
    stage.lose(of(Odometry))
    epoch = stage.fence.epoch.next(3, stage.lives[3])
    stage.deliver(Post(3, 0, 0, Raise(epoch=epoch, cause=Cause.PLEA)))
    assert stage.fence.epoch == epoch
    stage.resume_world()
    stage.post(*orders)
    stage.run(lambda: not stage.mail)
    assert stage.moving() == set()
    stage.pass_s(0.5)
    assert stage.moving() == set()
    stage.heal()
    stage.run(lambda: stage.fence.may is May.ALL)


def test_no_robot_takes_its_place_before_the_fence_is_in_force(monkeypatch: pytest.MonkeyPatch) -> None:
    """Until then bodies may still brake, so where they stand is not known."""
    with monkeypatch.context() as not_yet:
        not_yet.setattr("agents.membership.membership.in_force", lambda _: False)
        stage = ViewStage.driving()
        stage.pass_s(0.5)
        assert {process.robot.state for process in stage.processes.values()} == {State.BOUND}
    stage.pass_s(0.5)
    assert {process.robot.state for process in stage.processes.values()} == {State.MEMBER}


def test_v15_a_world_that_is_started_again_raises_the_fence_before_it_obeys_anything() -> None:
    stage = ViewStage.driving()
    stage.run(lambda: stage.moving() == {1, 2, 3})
    before = stage.fence
    orders = [[post for post in stage.sent(moves) if post.sender == robot][-1] for robot in stage.robots]
    stage.resume_world()
    epoch = stage.fence.epoch
    assert (epoch.generation, epoch.robot, stage.fence.may) == (2, 0, May.NOBODY)
    stage.post(*(order._replace(thing=_now(order.thing, stage)) for order in orders))
    stage.run(lambda: not stage.mail)
    assert stage.moving() == set()
    assert len(stage.records_of(OrderRefused)) >= len(orders)
    assert stage.records_of(FenceChanged)[-1].cause is Cause.WORLD_RESTARTED
    stage.run(lambda: stage.fence.may is May.ALL)
    assert stage.fence.epoch.generation > before.epoch.generation


def _now(drive: Drive, stage: ViewStage) -> Drive:
    """The same order, confirmed just now, and numbered beyond all that the world knows."""
    return Drive(
        number=drive.number + 1000,
        basis_s=stage.now_s,
        target=drive.target,
        speed_mps=drive.speed_mps,
        bearing=drive.bearing,
        step=drive.step,
        reach_m=drive.reach_m,
    )


def test_v11_nobody_raises_over_an_emergency_stop_until_it_is_released() -> None:
    stage = ViewStage.driving()
    stage.run(lambda: stage.moving() == {1, 2, 3})
    stage.deliver(Post(OPERATOR, 0, 0, Stop()))
    stopped = stage.fence
    assert (stopped.may, stage.moving()) == (May.STOPPED, set())
    since = len(stage.posted)
    stage.kill(1)
    stage.pass_s(10.0)
    assert not [post for post in stage.posted[since:] if isinstance(post.thing, Raise)]
    forced = Raise(epoch=stopped.epoch.next(2, stage.lives[2]), cause=Cause.COORDINATOR_LOST)
    stage.deliver(Post(2, 0, 0, forced))
    assert stage.fence == stopped
    stage.deliver(Post(OPERATOR, 0, 0, Release(generation=stopped.epoch.generation)))
    stage.run(lambda: stage.fence.may is May.ALL, s_max=10.0)
    assert stage.fence.members == 2


def test_v24_a_late_release_ends_no_second_stop() -> None:
    stage = ViewStage.driving()
    stage.deliver(Post(OPERATOR, 0, 0, Stop()))
    release = Post(OPERATOR, 0, 0, Release(generation=stage.fence.epoch.generation))
    stage.deliver(release)
    assert stage.fence.may is May.NOBODY
    stage.deliver(Post(OPERATOR, 0, 0, Stop()))
    stopped = stage.fence
    stage.deliver(release)
    stage.pass_s(2.0)
    assert stage.fence == stopped


def test_a_stop_outlives_the_world_that_was_told_of_it() -> None:
    stage = ViewStage.driving()
    stage.deliver(Post(OPERATOR, 0, 0, Stop()))
    stage.resume_world()
    stage.pass_s(2.0)
    assert stage.fence.may is May.STOPPED


def test_a_coordinator_that_is_silent_is_given_up_and_another_takes_its_place() -> None:
    stage = ViewStage.begun()
    stage.raised_by(3)
    stage.lose(lambda post: post.sender == 3 and post.receiver != 0)
    epoch = stage.fence.epoch
    stage.run(lambda: stage.fence.epoch != epoch, s_max=5.0)
    assert stage.fence.epoch.robot in {1, 2}
    said = [record for robot in (1, 2) for record in stage.records_of(ViewProposed, robot)]
    assert said[-1].cause is Cause.COORDINATOR_LOST


def test_outsiders_of_a_strand_whose_leader_is_deaf_are_heard_when_they_are_more_than_it() -> None:
    stage = ViewStage.begun()
    stage.raised_by(1)
    deaf = (2, 3)
    stage.lose(lambda post: {post.sender, post.receiver} in ({1, other} for other in deaf))
    stage.run(lambda: stage.fence.may is May.ALL, s_max=10.0)
    assert stage.fence.members == 1
    stage.run(lambda: stage.fence.members == 2, s_max=60.0)
    assert stage.formed is not None
    assert set(stage.formed.order) == set(deaf)
