"""A robot whose own process was late holds nobody for lost because of that."""

from agents.liveness.timing import Timing
from protocol.wire.messages import Odometry
from protocol.wire.view import Report
from tests.support.stages.view_stage import ViewStage, of

LATE_S = 1.4
"""Longer than a coordinator waits for reports, shorter than it takes the others to give it up."""


def test_a_coordinator_that_was_late_itself_waits_for_the_reports_that_have_come_meanwhile() -> None:
    stage = ViewStage.begun()
    stage.hold(of(Report))
    stage.run(lambda: any(process.robot.coordinates for process in stage.processes.values()))
    late = stage.fence.epoch.robot
    stage.forget()
    assert Timing().reports_s < LATE_S < Timing().coordinator_s
    stage.hold(of((Report, Odometry), receiver=late))
    stage.pass_s(LATE_S)
    waited = stage.forget()
    # The newest odometry sets the time; the reports come in the order in which they arrived.
    newest = max((post for post in waited if isinstance(post.thing, Odometry)), key=lambda post: post.thing.n)
    reports = [post for post in waited if isinstance(post.thing, Report) and post.sender != late]
    assert {post.sender for post in reports} == set(stage.robots) - {late}
    process = stage.processes[late]
    process.now_s = newest.thing.t_s
    stage.post(*reports, newest)
    stage.run(lambda: stage.formed is not None)
    assert stage.formed is not None
    assert sorted(stage.formed.order) == list(stage.robots)
