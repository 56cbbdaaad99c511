"""A robot lies about its way to the robot ahead, about who leads, or about the turn in which all drive."""

import math

from msgspec.structs import replace

from protocol.fence import May, Raise
from protocol.frames import Point
from protocol.path import Path
from protocol.wire.view import Formation, Report
from tests.support.stages.view_stage import ViewStage, of

LAST = 3
LIES = 6  # some of them after ALL
FAR_OFF = Point(x_m=1.0, y_m=-12.0)


def test_a_way_that_leads_elsewhere_does_not_put_the_robot_ahead_there() -> None:
    """S1: the robot ahead had its place far off, so it drove from where it stood to there, through a post."""
    stage, lies = ViewStage.begun(), 0
    while stage.fence.may is not May.ALL:
        if stage.mail and of(Report, sender=LAST)(stage.mail[0]) and (report := stage.mail[0].thing).look:
            way = Point(x_m=report.place.x_m, y_m=report.place.y_m), FAR_OFF
            lie = replace(report, look=replace(report.look, clear=True, way=way))
            stage.mail[0], lies = stage.mail[0]._replace(thing=lie), lies + 1
        stage.step()
    assert lies > 0
    formed = stage.formed
    assert formed is not None
    path = Path(formed.laid)
    for robot, place_m in zip(formed.order, formed.places_m, strict=True):
        at = path.at(place_m)
        assert math.dist((at.x_m, at.y_m), stage.place(robot)) <= stage.scenario.law.mu0_m


def test_a_robot_that_all_does_not_name_does_not_lead_whatever_its_coordinator_says() -> None:
    """S2: two leaders of one epoch, of which neither follows anybody, drove into each other."""
    stage = ViewStage.begun()
    stage.raised_by(1)
    epoch, lies = stage.fence.epoch, 0
    while stage.fence.may is not May.ALL or not stage.moving():
        if stage.mail and of(Formation)(stage.mail[0]) and stage.mail[0].thing.rank > 0:
            lie = replace(stage.mail[0].thing, rank=0, ahead=None)
            stage.mail[0], lies = stage.mail[0]._replace(thing=lie), lies + 1
        stage.step()
    stage.lose(of(Raise))
    stage.pass_s(1.0)
    assert lies > 0
    assert stage.fence.epoch == epoch
    leads = {robot for robot in stage.robots if stage.processes[robot].robot.leads}
    assert leads == {stage.fence.robot}


def test_a_formation_of_another_turn_than_that_of_all_makes_nobody_a_member() -> None:
    """V19: a formation names the turn of its ALL, so that its places are of no earlier turn."""
    stage = ViewStage.begun()
    stage.raised_by(1)
    lies = 0
    while stage.fence.may is not May.ALL or lies < LIES:
        if stage.mail and of(Formation)(stage.mail[0]):
            lie = replace(stage.mail[0].thing, turn=stage.mail[0].thing.turn + 1)
            stage.mail[0], lies = stage.mail[0]._replace(thing=lie), lies + 1
        stage.step()
    assert {robot for robot in stage.robots if stage.processes[robot].robot.member} == {1}, "its coordinator"
