"""What a coordinator tells the robots of its view."""

import pytest

from agents.commands import Command, Say
from agents.coordinating.agreeing import Agreement, Intent
from agents.coordinating.draft import Draft
from agents.coordinating.questions import Questions
from agents.coordinating.reported import Reported
from agents.coordinating.telling import Telling
from agents.coordinating.turns import Turns
from agents.liveness.suspicion import Suspicion
from agents.liveness.timing import Timing
from protocol.fence import Cause, Epoch, Fence, May
from protocol.frames import Pose
from protocol.wire.messages import Odometry, Phase
from protocol.wire.view import Answer, Formation, Report, ViewMessage
from tests.support.stages.one_step import under

TIMING, EPOCH = Timing(), Epoch(generation=2, robot=1, life=1)
PLACED, OTHER = (1, 2), 3


def report(robot: int) -> Report:
    place = Pose(x_m=float(-robot), y_m=0.0, heading_rad=0.0)
    return Report(epoch=EPOCH, life=robot, number=1, turn=9, place=place)


def said(had_turn: set[int], *, is_made: bool) -> dict[int, ViewMessage]:
    """What robots are told when all have reported; 1 and 2 are in the formation, once it is made."""
    reports = {robot: report(robot) for robot in (*PLACED, OTHER)}
    reported, turns = Reported(Suspicion(TIMING), 3, reports, 0.0), Turns(Fence(epoch=EPOCH), TIMING, 0.0)
    for robot, each in reports.items():
        reported.hear(robot, each, 0.0)
    for number, robot in enumerate(sorted(had_turn)):
        turns.put(Fence(epoch=EPOCH, turn=number), 0.0, may=May.ONE, robot=robot, life=robot)
    mission = under("certified", robots=3)
    draft = Draft(mission, Cause.START, strand=PLACED)
    telling = Telling(TIMING, reported, Questions(mission, TIMING), turns, draft)
    telling.ask((*PLACED, OTHER))
    told: list[Command] = []
    if is_made:
        agreement = Agreement(EPOCH, Intent(Cause.START), mission, reports, turns.put_for)
        told = telling.tell(agreement.drafted(PLACED, {}, turn=9), 0.0)
    odometry = Odometry(
        n=1, t_s=0.0, pose=report(1).place, moving=False, finished=0, fence=Fence(), phase=Phase.RUNNING
    )
    told += telling.act(odometry, 0.0, awaited=frozenset, map_from=frozenset())
    return {each.robot: each.said for each in told if isinstance(each, Say)}


def answers(had_turn: set[int], *, is_made: bool) -> dict[int, Answer]:
    told = said(had_turn, is_made=is_made)
    return {robot: each for robot, each in told.items() if isinstance(each, Answer)}


@pytest.mark.parametrize("had_turn", [set(), {2}, {3}, {2, 3}])
def test_members_are_told_who_had_a_turn_and_has_no_place_in_the_formation(had_turn: set[int]) -> None:
    told = said(had_turn, is_made=True)
    stranded = {robot: each.stranded for robot, each in told.items() if isinstance(each, Formation)}
    assert stranded == dict.fromkeys(PLACED, tuple({OTHER} & had_turn))


@pytest.mark.parametrize("is_made", [True, False])
def test_once_the_formation_is_made_its_robots_are_sent_that_and_no_answers(*, is_made: bool) -> None:
    assert answers({2, 3}, is_made=is_made).keys() == ({OTHER} if is_made else {*PLACED, OTHER})


def test_a_robot_is_told_its_rank_in_the_strand() -> None:
    assert {robot: each.rank for robot, each in answers(set(), is_made=False).items()} == {
        1: 0,
        2: 1,
        3: None,
    }
