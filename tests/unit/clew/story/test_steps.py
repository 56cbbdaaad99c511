"""Each step has the log's number and ends when it is finished, abandoned or broken off."""

from msgspec.structs import replace

from clew.story.steps import chosen_gap, gap_ends
from clew.story.story import Story
from protocol.frames import Point
from protocol.timeline import FaultInjected, Record, SeenGap, SeenObstacle, StepAbandoned, StepFinished
from tests.support.logs.logs import numbered
from tests.support.planned import planned

KILLED = FaultInjected(fault="kill", rule="a", process="r1")


def told(*records: tuple[str, Record]) -> list[tuple[int, int, float, float | None, str]]:
    """Number, robot, times of plan and end, and the kind of end."""
    story = Story()
    for source, entry in numbered(records):
        story.hear(source, entry)
    return [
        (
            each.number,
            each.robot,
            each.t_s,
            None if each.end is None else each.end.t_s,
            "" if each.end is None else str(each.end.how),
        )
        for each in story.all_steps()
    ]


def finished(step: int) -> StepFinished:
    return StepFinished(robot=1, step=step, x_m=1.0, y_m=0.0, clearance_m=0.2)


def test_a_step_is_under_way_until_it_ends() -> None:
    assert told(("r1", planned(1))) == [(1, 1, 0.0, None, "")]
    assert told(("r1", planned(1)), ("world", finished(1))) == [(1, 1, 0.0, 1.0, "finished")]
    abandoned = StepAbandoned(step=1, epoch=1, x_m=0.0, y_m=0.0)
    assert told(("r1", planned(1)), ("r1", abandoned)) == [(1, 1, 0.0, 1.0, "abandoned")]


def test_a_step_is_broken_off_by_its_leaders_death_or_the_next_step() -> None:
    again = ("r2", replace(planned(2), epoch=2))
    assert told(("r1", planned(1)), ("world", KILLED), again) == [
        (1, 1, 0.0, 1.0, "broken off"),
        (2, 2, 2.0, None, ""),
    ]
    assert told(("r1", planned(1)), again)[0] == (1, 1, 0.0, 1.0, "broken off")


def test_a_step_of_a_joining_robot_is_separate() -> None:
    assert told(("r1", replace(planned(1), joins=True))) == []


def test_a_gap_opens_between_the_obstacles_at_its_sides() -> None:
    right, left = (
        SeenObstacle(tangent_1=Point(x_m=x_m, y_m=1.0), tangent_2=Point(x_m=x_m, y_m=2.0), chord_m=1.0)
        for x_m in (0.0, 1.0)
    )
    gap = SeenGap(right=0, left=1, width_m=1.0, delta_rad=1.0, passable=True)
    plan = replace(planned(1), obstacles=(right, left), gaps=(gap, replace(gap, left=2)), gap=0)
    assert gap_ends(plan) == ((right.tangent_2, left.tangent_1), None)
    assert chosen_gap(plan) == (right.tangent_2, left.tangent_1)
    assert chosen_gap(replace(plan, gap=1)) is None
    assert chosen_gap(replace(plan, gap=None)) is None
