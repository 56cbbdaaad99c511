"""A leader dies, to be read aloud: raise, fence, reports, order, formation, ALL, first order."""

import pytest

from protocol.fence import Cause, May, Raise, Turn
from protocol.timeline import FenceChanged, LeaderSucceeded, LinkBroken, StrandHealed, ViewJoined
from protocol.wire.messages import Drive
from protocol.wire.view import Formation, Report
from tests.support.stages.view_stage import ViewStage, of


def test_a_leader_dies_and_the_others_form_a_strand_without_it() -> None:
    stage = ViewStage.driving()
    stage.run(lambda: stage.moving() == {1, 2, 3})
    stage.kill(1)
    first = len(stage.posted)

    # Robot 2 sees the token of its neighbour gone, and raises the fence.
    stage.run(lambda: stage.fence.epoch.generation == 2)
    (raised,) = [post for post in stage.posted[first:] if isinstance(post.thing, Raise)]
    assert (raised.sender, raised.thing.cause) == (2, Cause.NEIGHBOUR_LOST)
    assert stage.records_of(LinkBroken, 2)[-1].neighbour == 1

    # Nobody may move: all bodies stand, and each robot says that it is bound.
    assert (stage.fence.may, stage.fence.turn, stage.moving()) == (May.NOBODY, 0, set())
    stage.run(lambda: {2, 3} == {source for source, _, record in stage.records
                                 if isinstance(record, ViewJoined) and record.epoch == 20002})  # fmt: skip

    # Both report to robot 2, which makes the formation: robot 2 leads, robot 3 follows.
    stage.run(lambda: stage.formed is not None)
    reports = [post.thing for post in stage.posted[first:] if isinstance(post.thing, Report)]
    assert {(report.epoch.number, report.turn) for report in reports} == {(20002, 0)}
    assert stage.formed is not None
    assert (stage.formed.order, stage.formed.turn) == ((2, 3), 1)

    # Its pieces are sent before ALL is put, and ALL names the leader.
    stage.run(lambda: stage.fence.may is May.ALL)
    after = stage.posted[first:]
    told = max(index for index, post in enumerate(after) if isinstance(post.thing, Formation))
    put = min(index for index, post in enumerate(after) if isinstance(post.thing, Turn))
    assert told < put
    assert (stage.fence.robot, stage.fence.members, stage.fence.turn) == (2, 2, 1)

    # Robot 2 takes over, and drives first.
    began_s = stage.now_s
    stage.run(lambda: any(of(Drive, sender=2)(post) and post.thing.target for post in stage.posted[first:]
                          if post.thing in _under(stage)))  # fmt: skip
    assert stage.records_of(LeaderSucceeded, 2)[-1].before == 1
    assert stage.records_of(StrandHealed, 2)[-1].robots == 2
    stage.run(lambda: 2 in stage.moving())
    assert stage.now_s - began_s < 1.0
    assert [change.may for change in stage.records_of(FenceChanged) if change.epoch == 20002] == [
        May.NOBODY,
        May.ALL,
    ]


def _under(stage: ViewStage) -> list[object]:
    """What was sent under the fence in force."""
    return [
        post.thing
        for post in stage.posted
        if isinstance(post.thing, Drive)
        and (post.thing.bearing.epoch, post.thing.bearing.turn) == (stage.fence.epoch, stage.fence.turn)
    ]


@pytest.mark.parametrize("comes_back", [False, True])
def test_if_the_coordinator_dies_and_nobody_has_the_formation_the_robot_that_was_to_lead_raises(
    comes_back: bool,
) -> None:
    """All are left out, and they do not outnumber the strand: only its leader can say that there is none."""
    stage = ViewStage.begun()
    stage.raised_by(3)
    stage.lose(of(Formation))
    stage.run(lambda: stage.fence.may is May.ALL)
    assert stage.fence.robot == 1
    stage.kill(3)
    stage.heal()
    if comes_back:
        stage.start(3)
    stage.run(lambda: stage.fence.may is May.ALL and stage.fence.epoch.generation == 2)
    assert stage.fence.members == len(stage.processes)
    stage.run(lambda: 1 in stage.moving())


def test_a_strand_of_which_all_robots_have_new_lives_forms_again() -> None:
    stage = ViewStage.driving()
    stage.run(lambda: stage.moving() == {1, 2, 3})
    for robot in stage.robots:
        stage.replace(robot)
    stage.run(lambda: stage.fence.may is May.ALL and stage.fence.epoch.generation == 2)
    stage.run(lambda: stage.moving() == {1, 2, 3})
