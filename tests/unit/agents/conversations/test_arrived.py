"""Robots at the goal, where a strand drives no further, and others that are to come there."""

import math

import pytest
from msgspec.structs import replace

from clew.explore.setting import Setting
from protocol.fence import May
from protocol.mission import Bounds
from protocol.timeline import RobotArrived, StepPlanned
from tests.support.stages.view_stage import ViewStage

BESIDE_A_BODY = ((3.4, 1.76, 0.0), (3.4, 1.5, 0.0))
"""The second robot is at the goal, and as near to the first one as robots stand. That is below epsilon."""
NO_OTHER_ROOM = ((3.4, 1.63, 0.0), (3.4, 1.37, 0.0), (2.8, 1.37, 0.0))
IN_PLACE = ((3.4, 1.66, 0.0), (3.4, 1.4, 0.0), (3.14, 1.4, 0.0))
NARROW = Bounds(x_m_min=2.8, x_m_max=4.0, y_m_min=1.25, y_m_max=1.85)
PLACES = ((2.0, 1.0, 0.0), (1.4, 1.0, 0.0), (2.0, 2.2, 0.0), (1.2, 2.2, 0.0))


def arrived(stage: ViewStage) -> set[int]:
    return {robot for robot, _, said in stage.records if isinstance(said, RobotArrived)}


def test_robots_that_stand_too_near_to_each_other_to_come_behind_the_last_one_come_before_it() -> None:
    stage = ViewStage.driving(PLACES)
    stage.run(lambda: len(arrived(stage)) == 4)
    assert stage.formed is not None
    before = stage.formed.order
    stage.kill(middle := before[2])
    stage.start(middle)
    generation = stage.fence.epoch.generation
    stage.run(
        lambda: (
            stage.fence.epoch.generation > generation
            and stage.fence.may is May.ALL
            and stage.fence.members == len(before)
        ),
        s_max=20.0,
    )
    assert stage.formed.order == (before[0], before[3], middle, before[1])


@pytest.mark.parametrize("behind", [(2.8, 1.44, 0.0), (3.4, 0.9, 0.0)], ids=["sees the body", "does not"])
def test_a_leader_that_begins_at_the_goal_beside_a_body_goes_on_to_where_others_may_come(
    behind: tuple[float, float, float],
) -> None:
    stage = ViewStage.begun((*BESIDE_A_BODY, behind))
    stage.kill(1)
    stage.run(lambda: arrived(stage) == {2, 3})
    assert stage.formed is not None
    assert stage.scenario.goal is not None
    assert stage.formed.order == (2, 3)
    assert math.dist(stage.place(2), (3.4, 1.5)) <= stage.scenario.goal.tolerance_m


def test_a_leader_that_begins_beside_a_body_at_a_goal_with_no_other_room_has_arrived() -> None:
    stage = ViewStage.begun(NO_OTHER_ROOM)
    stage.kill(1)
    stage.run(lambda: arrived(stage) == {2})
    assert stage.place(2) == NO_OTHER_ROOM[1][:2]


def test_a_leader_beside_a_body_stays_at_the_goal_where_others_are_in_place_behind_it() -> None:
    """It went on, so the robot behind it was in place no more, and found no other place for good."""
    scenario = Setting(name="stage", about="a conversation", places=IN_PLACE).scenario()
    assert scenario.goal is not None
    goal = replace(scenario.goal, tolerance_m=0.2)
    stage = ViewStage.begun(IN_PLACE, replace(scenario, goal=goal, bounds=NARROW))
    stage.run(lambda: arrived(stage) == {1, 2, 3})
    stage.kill(1)
    stage.records.clear()
    stage.run(lambda: arrived(stage) == {2, 3})
    assert stage.records_of(StepPlanned) == []
