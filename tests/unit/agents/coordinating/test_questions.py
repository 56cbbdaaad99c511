"""What a coordinator asks robots to look at."""

import pytest

from agents.coordinating.questions import Questions
from agents.liveness.timing import Timing
from protocol.fence import Epoch
from protocol.frames import Point, Pose
from protocol.wire.view import Former, Look, Report
from tests.support.stages.one_step import under

EPOCH = Epoch(generation=1, robot=1, life=5)
MISSION = under("certified", robots=3, robot_radius_m=0.1)
TIMING = Timing()
ORDER = (1, 2, 3)


def report(x_m: float, *, formers: tuple[Former, ...] = ()) -> Report:
    place = Pose(x_m=x_m, y_m=0.0, heading_rad=0.0)
    return Report(epoch=EPOCH, life=7, number=1, turn=0, place=place, formers=formers)


QUEUE = {1: report(2.0), 2: report(1.0), 3: report(0.0)}


def asked() -> Questions:
    questions = Questions(MISSION, TIMING)
    assert questions.ask(ORDER, QUEUE, 0.0, turn=0, keeps=True) == [2, 3]
    return questions


def test_all_but_the_leader_are_asked_about_the_leg_to_the_robot_ahead() -> None:
    questions = asked()
    assert questions.pending(1) is None
    for robot, ahead in ((2, 1), (3, 2)):
        question = questions.pending(robot)
        assert question is not None
        assert question.place == QUEUE[ahead].place
        assert QUEUE[ahead].place.x_m in [point.x_m for point in question.others]


def test_an_answer_counts_if_it_is_to_the_newest_question() -> None:
    questions = asked()
    question = questions.pending(2)
    assert question is not None
    questions.hear(2, Look(number=question.number + 1, clear=True))
    questions.hear(2, None)
    assert questions.pending(2) == question
    questions.hear(2, Look(number=question.number, clear=True))
    assert (questions.pending(2), questions.sees(2).clear) == (None, True)


@pytest.mark.parametrize(
    ("from_m", "to_m", "counts"),
    [((1.0, 0.0), (2.0, 0.0), True), ((1.0, 0.0), (1.0, -12.0), False), ((9.0, 0.0), (2.0, 0.0), False)],
)
def test_a_driven_way_counts_only_if_it_leads_from_the_robot_to_the_one_ahead(
    from_m: tuple[float, float], to_m: tuple[float, float], counts: bool
) -> None:
    """Else a robot that lies could lead the robot ahead astray: the end of the way is laid as its place."""
    questions = asked()
    question = questions.pending(2)
    assert question is not None
    way = tuple(Point(x_m=x_m, y_m=y_m) for x_m, y_m in (from_m, to_m))
    questions.hear(2, Look(number=question.number, clear=True, way=way))
    assert (questions.sees(2).clear, questions.sees(2).driven) == (counts, counts)
    assert questions.pending(2) is None, "it is not waited for"


def test_all_are_answered_when_each_has_or_was_waited_for_long_enough() -> None:
    questions = asked()
    for robot in (2, 3):
        assert questions.awaited(TIMING.looks_s)
        question = questions.pending(robot)
        assert question is not None
        questions.hear(robot, Look(number=question.number, clear=True))
    assert not questions.awaited(0.0)
    assert not asked().awaited(TIMING.looks_s + 0.1)
    assert not asked().sees(2).clear, "a robot that does not answer does not see its way"


def test_a_robot_that_owes_an_answer_is_not_waited_for_anew_when_its_question_changes() -> None:
    questions = asked()
    question = questions.pending(3)
    assert question is not None
    late_s = TIMING.looks_s + 0.1
    questions.hear(3, Look(number=question.number, clear=True))
    assert set(questions.ask((1, 3, 2), QUEUE, late_s, turn=0, keeps=True)) == {2, 3}
    assert questions.awaited(late_s), "the one that had answered has all its time"
    question = questions.pending(3)
    assert question is not None
    questions.hear(3, Look(number=question.number, clear=True))
    assert not questions.awaited(late_s), "the other one has had its time"


def test_the_same_question_is_not_asked_again_while_both_stand_where_they_stood() -> None:
    questions = asked()
    question = questions.pending(2)
    assert question is not None
    questions.hear(2, Look(number=question.number, clear=True))
    assert questions.ask(ORDER, QUEUE, 1.0, turn=0, keeps=True) == []
    assert questions.sees(2).clear
    assert questions.ask(ORDER, {**QUEUE, 1: report(2.5)}, 2.0, turn=0, keeps=True) == [2]
    assert not questions.sees(2).clear, "the robot ahead has moved: it has to look anew"


def test_after_a_turn_legs_are_looked_at_anew_unless_they_have_been_driven() -> None:
    questions = asked()
    ways: dict[int, tuple[Point, ...]] = {2: (), 3: (Point(x_m=0.0, y_m=0.0), Point(x_m=1.0, y_m=0.0))}
    for robot, way in ways.items():
        question = questions.pending(robot)
        assert question is not None
        questions.hear(robot, Look(number=question.number, clear=True, way=way))
    assert questions.ask(ORDER, QUEUE, 1.0, turn=0, keeps=True) == []
    assert questions.ask(ORDER, QUEUE, 1.0, turn=1, keeps=True) == [2]
    assert not questions.sees(2).clear, "a robot may stand on its leg"


def test_a_robot_that_has_another_robot_ahead_is_asked_anew() -> None:
    questions = asked()
    assert set(questions.ask((2, 1, 3), QUEUE, 1.0, turn=0, keeps=True)) == {1, 3}
    assert questions.pending(2) is None


def test_places_in_former_strands_are_told_only_where_they_count() -> None:
    former = Former(epoch=EPOCH, rank=0, s_m=1.0)
    there = {**QUEUE, 1: report(2.0, formers=(former,))}
    for keeps, formers in ((True, (former,)), (False, ())):
        questions = Questions(MISSION, TIMING)
        questions.ask(ORDER, there, 0.0, turn=0, keeps=keeps)
        question = questions.pending(2)
        assert question is not None
        assert question.formers == formers


def test_without_a_goal_all_are_asked_how_far_off_the_nearest_obstacle_is() -> None:
    questions = Questions(MISSION, TIMING)
    assert questions.ask((), QUEUE, 0.0, turn=0, keeps=True) == [1, 2, 3]
    question = questions.pending(1)
    assert question is not None
    assert question.place is None
    questions.hear(1, Look(number=question.number, obstacle_m=0.7))
    assert questions.obstacle_m((1, 2)) == {1: 0.7, 2: MISSION.range_m_max}


def test_a_robot_that_is_dropped_is_not_waited_for() -> None:
    questions = asked()
    questions.ask((1,), {1: QUEUE[1]}, 1.0, turn=0, keeps=True)
    assert not questions.awaited(1.0)
    questions.ask((), QUEUE, 2.0, turn=0, keeps=True)
    assert questions.ask((), {}, 3.0, turn=0, keeps=True) == []
    assert not questions.awaited(3.0)


def test_no_more_robots_are_named_than_a_question_holds() -> None:
    many = {robot: report(robot / 1000.0) for robot in range(1, 101)}
    questions = Questions(under("certified", robots=100, robot_radius_m=0.1), TIMING)
    questions.ask(tuple(many), many, 0.0, turn=0, keeps=True)
    question = questions.pending(50)
    assert question is not None
    assert len(question.others) == 64
    assert Point(x_m=0.049, y_m=0.0) in question.others
