"""What decides the state of a robot: the fence, its coordinator's answers, and its formation."""

from agents.membership.states import State
from clew.explore.setting import SCATTERED
from protocol.fence import May
from protocol.wire.view import Answer
from tests.support.stages.view_stage import ViewStage, of


def states(stage: ViewStage) -> dict[int, State]:
    return {robot: process.robot.state for robot, process in stage.processes.items()}


def test_a_robot_joins_just_while_a_turn_names_it_and_is_a_member_only_under_all() -> None:
    stage, seen = ViewStage.begun(SCATTERED), set[State]()

    def formed() -> bool:
        for robot, process in stage.processes.items():
            fence, state = process.robot.fence, process.robot.state
            seen.add(state)
            assert (state is State.JOINING) is (fence.may is May.ONE and fence.robot == robot)
            assert state is not State.MEMBER or fence.may is May.ALL
        return set(states(stage).values()) == {State.MEMBER}

    stage.run(formed)
    assert seen == {State.BOUND, State.JOINING, State.MEMBER}


def test_a_turn_that_names_another_life_of_a_robot_lets_this_one_not_join() -> None:
    stage = ViewStage.begun(SCATTERED)
    stage.run(lambda: State.JOINING in states(stage).values())
    robot = stage.fence.robot
    stage.replace(robot)
    stage.run(lambda: stage.processes[robot].told is not None)
    assert (stage.fence.robot, states(stage)[robot]) == (robot, State.BOUND)


def test_a_robot_that_is_left_out_stands_aside_until_a_newer_epoch() -> None:
    stage = ViewStage.driving()
    stage.replace(3)
    stage.run(lambda: states(stage)[3] is State.ASIDE)
    stage.lose(of(Answer, receiver=3))
    epoch = stage.fence.epoch
    stage.run(lambda: stage.processes[3].robot.fence.epoch != epoch, s_max=30.0)
    assert states(stage)[3] is State.BOUND
