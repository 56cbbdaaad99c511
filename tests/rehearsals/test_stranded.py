"""A robot that dies in a passage plugs it: those in front go on, the others are stranded."""

from functools import cache

import pytest

from clew.rehearsal.rehearsal import Rehearsal
from protocol.exit_codes import ExitCode
from protocol.faults.plan import NO_FAULTS, Plan, uniform
from protocol.faults.rules import Kill, Partition
from protocol.timeline import RobotStranded, RunEnded
from tests.support.faults import kill
from tests.support.scenes.corridor import PASSAGE_M, passage
from tests.support.scenes.dead_ends import corridors, scene, walls_round
from world.closing import Circumstances, verdict_of
from world.judge.ending import Ending
from world.judge.judgement import judge
from world.scenario.scenario import load

# After the death: 65 s of six robots with three in front, 76 s with loss; 292 s of eight before.
ENDS_WITHIN_S = 130.0
LOSSY = uniform(delay_s_max=0.1, loss=0.3, repeat=0.1)


@cache
def plugged(robots: int, dies: int, *, lossy: bool = False) -> tuple[Rehearsal, float]:
    """Robots of which one dies in the middle of the passage, to read; also returns when it died."""
    rehearsal = Rehearsal(passage(robots), 1, LOSSY if lossy else NO_FAULTS)
    died_s = None
    for now_s in rehearsal.ticks():
        if died_s is None and rehearsal.world.bodies.place_m[dies - 1, 0] > PASSAGE_M / 2.0:
            kill(rehearsal, dies)
            died_s = now_s
    assert died_s is not None
    return rehearsal, died_s


def stranded(rehearsal: Rehearsal) -> list[RobotStranded]:
    return [entry.record for _, entry in rehearsal.entries if isinstance(entry.record, RobotStranded)]


@pytest.mark.parametrize(
    ("robots", "dies", "lossy"),
    [
        pytest.param(5, 2, False, id="one in front"),
        pytest.param(6, 4, False, id="three", marks=pytest.mark.long),
        pytest.param(6, 4, True, id="three, 30 % lost", marks=pytest.mark.long),
    ],
)
def test_robots_in_front_of_the_body_arrive_and_the_run_ends_soon(
    robots: int, dies: int, *, lossy: bool
) -> None:
    rehearsal, died_s = plugged(robots, dies, lossy=lossy)
    world = rehearsal.world
    assert judge(world.scenario, rehearsal.entries).breaches == ()
    assert world.ending is Ending.STRANDED
    assert world.tally.arrived == set(range(1, dies))
    assert world.tally.stranded_among(world.attendance.living) == list(range(dies + 1, robots + 1))
    assert world.over_s - died_s < ENDS_WITHIN_S


def test_the_timeline_names_who_is_stranded_and_whose_body_is_in_the_way() -> None:
    rehearsal, _ = plugged(5, 2, lossy=False)
    assert [(each.robot, each.by) for each in stranded(rehearsal)[:3]] == [(3, 2), (4, 2), (5, 2)]
    verdict = verdict_of(rehearsal.world, CIRCUMSTANCES)
    assert verdict.exit_code == ExitCode.FAILED
    ended = next(entry.record for _, entry in rehearsal.entries if isinstance(entry.record, RunEnded))
    assert ended.reason == f"{Ending.STRANDED}: r3, r4, r5"


@pytest.mark.long
@pytest.mark.parametrize("died_s", [8.0, 12.0, 16.0])
def test_one_that_is_locked_in_before_a_shut_door_lets_another_lead_through_the_other_opening(
    died_s: float,
) -> None:
    """It finds a short step every few seconds, and each time another joins in vain the view is new."""
    rehearsal = Rehearsal(
        load("door"), 1, Plan(name="killed", rules=(Kill(target="r2", from_s=died_s),))
    ).run()
    world = rehearsal.world
    assert judge(world.scenario, rehearsal.entries).breaches == ()
    assert (world.ending, world.tally.arrived) == (Ending.STRANDED, {3})
    assert [(each.robot, each.by) for each in stranded(rehearsal)[-1:]] == [(1, 2)]
    assert world.over_s < world.scenario.time.time_s_max


def test_behind_a_dead_leader_nobody_can_go_on_and_the_route_is_lost_soon() -> None:
    rehearsal, died_s = plugged(6, 1)
    assert judge(rehearsal.world.scenario, rehearsal.entries).breaches == ()
    assert rehearsal.world.ending is Ending.ROUTE_LOST
    assert rehearsal.world.over_s - died_s < ENDS_WITHIN_S


def test_a_body_behind_all_others_is_in_nobodys_way() -> None:
    rehearsal, _ = plugged(5, 5)
    assert rehearsal.world.ending is Ending.ARRIVED


@pytest.mark.parametrize("outage_s", [2.0, 20.0])
def test_after_an_outage_of_all_the_route_is_not_lost_before_the_one_in_front_can_come_back(
    outage_s: float,
) -> None:
    """Bodies stand in an outage, however long: that nobody moves says nothing of who comes back."""
    free = corridors([(-0.5, 0.0), (4.0, 0.0)])
    tube = scene(walls_round(free), robots=2, start=(0.0, 0.0, 0.0), goal=(3.5, 0.0))
    rules = (
        Partition(from_s=2.0, until_s=2.0 + outage_s, group=("r2",), others=("router",)),
        Partition(from_s=2.0, until_s=6.0 + outage_s, group=("r1",), others=("router",)),
    )
    rehearsal = Rehearsal(tube, 1, Plan(name="outage", rules=rules)).run()
    assert rehearsal.world.ending is Ending.ARRIVED


CIRCUMSTANCES = Circumstances(
    seed=1,
    speed=None,
    started_at="",
    plan=NO_FAULTS,
    traffic=None,
    recorded=0,
    missing={},
    wall_s=0.0,
    cpu_s=0.0,
)
