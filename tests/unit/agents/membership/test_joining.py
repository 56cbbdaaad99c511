"""Robots that start anywhere line up: joining one by one, without meeting, whatever the network does."""

import itertools
import math
from collections.abc import Iterator
from pathlib import Path
from random import Random

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from msgspec.structs import replace

from agents.membership import joining
from agents.membership.joining import InPlace, Joining
from agents.membership.stands import Stands
from agents.navigation.step import GAIN_M, LookCloser, NoStep, Step
from agents.navigation.sure import closer
from clew.rehearsal.rehearsal import Rehearsal
from protocol.faults.plan import NO_FAULTS, uniform
from protocol.frames import Pose
from protocol.mission import Mission
from protocol.timeline import (
    FenceChanged,
    OrderAccepted,
    RobotBlocked,
    RobotPlaced,
    ScanServed,
    StepPlanned,
    StrandFormed,
)
from tests.support.long import long
from tests.support.stages.one_step import look_around, under
from tests.support.strategies.examples import examples
from world.geometry.clearance import distances
from world.geometry.shapes import Circle, Polygon, Shape, ground_of
from world.judge.ending import Ending
from world.judge.judgement import judge
from world.scenario.scenario import Scenario, load

LOSSY = uniform(delay_s_max=0.3, loss=0.3, repeat=0.1)
PERFECT = NO_FAULTS
SIZE_M = (8.0, 6.0)
CLOSEST_M = 0.22  # r + epsilon, and the scan's doubt
APART_M = 0.32  # 2 r + separation, and a bit

HEAD = """
name = "anywhere"
[fleet]
robots = {robots}
robot_radius_m = 0.1
places = {places}
separation_m = 0.1
link_length_m_max = 1.5
[law]
epsilon_m = 0.1
mu0_m = 0.03
[goal]
at_m = {goal}
tolerance_m = 0.15
[bounds]
x_m_min = 0.0
y_m_min = 0.0
x_m_max = 8.0
y_m_max = 6.0
[sensor]
directions = 720
range_m_max = 4.0
range_sigma_m = 0.002
[drive]
speed_mps = 0.5
speed_mps_min = 0.05
speed_mps_max = 1.0
turn_rate_radps = 1.5
heading_error_rad = 0.001
[time]
time_s_max = 300.0
"""

Place = tuple[float, float]


def box(x_m: float, y_m: float, wide_m: float, high_m: float) -> Polygon:
    east_m, north_m = x_m + wide_m, y_m + high_m
    return Polygon(vertices_m=((x_m, y_m), (east_m, y_m), (east_m, north_m), (x_m, north_m)))


def toml_of(shape: Shape) -> str:
    if isinstance(shape, Circle):
        centre = list(shape.centre_m)
        return f'[[obstacle]]\nshape = "circle"\ncentre_m = {centre}\nradius_m = {shape.radius_m}\n'
    assert isinstance(shape, Polygon)
    return f'[[obstacle]]\nshape = "polygon"\nvertices_m = {[list(corner) for corner in shape.vertices_m]}\n'


def scenario(folder: Path, places: list[Place], shapes: list[Shape], goal: Place) -> Scenario:
    path = folder / "anywhere.toml"
    rows = [[x_m, y_m, 0.0] for x_m, y_m in places]
    head = HEAD.format(robots=len(rows), places=rows, goal=list(goal))
    path.write_text(head + "".join(map(toml_of, shapes)))
    return load(str(path))


def anywhere(folder: Path, seed: int) -> Scenario:
    """Five to eight robots at random free places among random circles and walls."""
    random = Random(seed)
    shapes: list[Shape] = [
        Circle(
            centre_m=(random.uniform(0.5, 7.5), random.uniform(0.5, 5.5)), radius_m=random.uniform(0.1, 0.4)
        )
        for _ in range(random.randint(4, 9))
    ]
    for _ in range(random.randint(1, 3)):
        wide_m, high_m = random.choice([(random.uniform(0.5, 1.5), 0.15), (0.15, random.uniform(0.5, 1.5))])
        shapes.append(box(random.uniform(0.5, 6.5), random.uniform(0.5, 4.5), wide_m, high_m))
    ground = ground_of(shapes)

    def free(off_m: float) -> Place:
        while True:
            place = (random.uniform(0.3, SIZE_M[0] - 0.3), random.uniform(0.3, SIZE_M[1] - 0.3))
            if distances(ground, np.array(place)).min() >= off_m:
                return place

    places: list[Place] = []
    robots = random.randint(5, 8)
    while len(places) < robots:
        place = free(CLOSEST_M)
        if all(math.dist(place, other) >= APART_M for other in places):
            places.append(place)
    return scenario(folder, places, shapes, free(0.6))


def replay(test: str, seed: int) -> str:
    return f"replay with  ./launch/test.sh 'tests/unit/agents/membership/test_joining.py::{test}[{seed}]'"


@pytest.mark.long  # in the short form they even arrive, below
@pytest.mark.parametrize("seed", [2, 4, 5, 7])
def test_robots_that_start_anywhere_line_up(tmp_path: Path, seed: int) -> None:
    rehearsal = Rehearsal(anywhere(tmp_path, seed), seed, LOSSY)
    for _ in ticks_until_formed(rehearsal):
        pass
    again = replay("test_robots_that_start_anywhere_line_up", seed)
    assert records(rehearsal, StrandFormed), again
    assert judge(rehearsal.world.scenario, rehearsal.entries).breaches == (), again


@pytest.mark.parametrize("seed", [1, *long([3, 6])])
def test_robots_that_started_anywhere_arrive(tmp_path: Path, seed: int) -> None:
    rehearsal = Rehearsal(anywhere(tmp_path, seed), seed, LOSSY).run()
    again = replay("test_robots_that_started_anywhere_arrive", seed)
    assert judge(rehearsal.world.scenario, rehearsal.entries).breaches == (), again
    assert rehearsal.world.ending is Ending.ARRIVED, again


def ticks_until_formed(rehearsal: Rehearsal) -> Iterator[float]:
    """The instants until some robot knows the strand: at that very one it may set out."""
    seen = 0  # entries grow by thousands: each is looked at once
    for now_s in rehearsal.ticks():
        news = rehearsal.entries[seen:]
        if any(isinstance(entry.record, StrandFormed) for _, entry in news):
            return
        seen += len(news)
        yield now_s


def records(rehearsal: Rehearsal, kind: type) -> list[object]:
    return [entry.record for _, entry in rehearsal.entries if isinstance(entry.record, kind)]


@settings(max_examples=examples(5))
@given(
    seed=st.integers(0, 1000),
    loss=st.sampled_from([0.0, 0.3, 0.7]),
    delay_s=st.sampled_from([0.0, 0.5, 2.0]),
)
def test_no_two_robots_move_at_once_before_the_strand_has_formed(
    tmp_path_factory: pytest.TempPathFactory, seed: int, loss: float, delay_s: float
) -> None:
    faults = uniform(delay_s_max=delay_s, loss=loss, repeat=0.1)
    rehearsal = Rehearsal(anywhere(tmp_path_factory.mktemp("anywhere"), seed), seed, faults)
    for _ in itertools.takewhile(lambda now_s: now_s < 30.0, ticks_until_formed(rehearsal)):
        assert rehearsal.world.bodies.moving.sum() <= 1


CORRIDOR: list[Shape] = [box(1.0, 2.0, 2.0, 0.1), box(1.0, 2.65, 2.0, 0.1), box(1.0, 2.1, 0.1, 0.55)]


def test_a_robot_that_stands_in_a_corridor_behind_another_joins_after_it(tmp_path: Path) -> None:
    # By air robot 2, at the inner end, is nearer to the leader outside than robot 3, which is in its way.
    fleet = scenario(tmp_path, [(1.3, 4.0), (1.4, 2.375), (1.9, 2.375)], CORRIDOR, (1.3, 5.3))
    rehearsal = Rehearsal(fleet, 1, PERFECT).run()
    assert judge(fleet, rehearsal.entries).breaches == ()
    assert rehearsal.world.ending is Ending.ARRIVED
    assert records(rehearsal, RobotBlocked)
    assert len(records(rehearsal, RobotPlaced)) == 2


def test_a_turn_ends_whose_way_is_much_longer_than_it_first_seemed(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(joining, "LONGER", 1.0)
    wall: list[Shape] = [box(3.0, 1.0, 0.15, 3.0)]
    fleet = scenario(tmp_path, [(3.8, 2.5), (2.4, 2.5)], wall, (7.0, 2.5))
    rehearsal = Rehearsal(fleet, 1, PERFECT).run()
    blocked, *_ = records(rehearsal, RobotBlocked)
    assert isinstance(blocked, RobotBlocked)
    assert blocked.reason == "the way to a place is much longer than it seemed"


def test_a_robot_behind_a_wall_goes_round_it_to_its_place(tmp_path: Path) -> None:
    wall: list[Shape] = [box(3.0, 1.0, 0.15, 3.0)]
    fleet = scenario(tmp_path, [(3.8, 2.5), (2.4, 2.5)], wall, (7.0, 2.5))
    rehearsal = Rehearsal(fleet, 1, PERFECT).run()
    assert judge(fleet, rehearsal.entries).breaches == ()
    assert rehearsal.world.ending is Ending.ARRIVED
    steps = [step for step in records(rehearsal, StepPlanned) if isinstance(step, StepPlanned) and step.joins]
    orders = [order for order in records(rehearsal, OrderAccepted) if isinstance(order, OrderAccepted)]
    assert steps
    assert {order.robot for order in orders[: len(steps)]} == {2}


def test_in_a_queue_nobody_moves_before_the_strand_has_formed_and_every_leg_is_looked_at_once(
    tmp_path: Path,
) -> None:
    fleet = scenario(tmp_path, [(3.0, 3.0), (2.6, 3.0), (2.2, 3.0)], [], (6.0, 3.0))
    rehearsal = Rehearsal(fleet, 1, PERFECT)
    for _ in ticks_until_formed(rehearsal):
        assert not rehearsal.world.bodies.moving.any()
    assert rehearsal.world.now_s < 1.0
    kinds = [type(entry.record) for _, entry in rehearsal.entries]
    assert kinds[: kinds.index(FenceChanged, kinds.index(StrandFormed))].count(ScanServed) == 2, "one a leg"
    assert not records(rehearsal, RobotPlaced)


# --- one robot's plan -----------------------------------------------------------------------------

MISSION = under("certified", robots=3, robot_radius_m=0.1)


def searching(mission: Mission, start: np.ndarray) -> Joining:
    search = Joining(mission)
    search.begin(start, epoch=0, robots=(1,))
    return search


def plan(
    shapes: list[Shape], stands: Stands, search: Joining | None = None
) -> StepPlanned | InPlace | NoStep:
    """What a robot plans, after closer looks if it wants them."""
    hulls: list[Shape] = [Circle(centre_m=(x, y), radius_m=0.1) for x, y in stands.all.tolist()]
    view = look_around([*shapes, *hulls], MISSION)
    search = search or searching(MISSION, view.position)
    while isinstance(planned := search.plan(view, stands), LookCloser):
        revolutions = closer(MISSION, len(view.ranges_m))
        assert revolutions is not None, "there is no closer look"
        view = look_around([*shapes, *hulls], MISSION, revolutions=revolutions)
    return planned


def stand(strand: list[Place], waiting: list[Place]) -> Stands:
    places = np.array(strand).reshape(-1, 2)
    return Stands(places, np.array(waiting).reshape(-1, 2), places, min(len(places) - 1, 1))


def test_a_robot_that_stands_at_a_place_with_a_clear_leg_is_in_place_without_a_step() -> None:
    assert plan([], stand([(0.6, 0.0)], [])) == InPlace()


@pytest.mark.parametrize(
    ("shapes", "stands"),
    [
        ([], stand([(2.0, 0.0)], [])),  # too far
        ([Circle(centre_m=(0.3, 0.15), radius_m=0.05)], stand([(0.6, 0.0)], [])),  # a post beside the leg
        ([], stand([(0.3, 0.5), (0.3, -0.2), (0.6, 0.0)], [])),  # folds back
        ([], stand([(0.8, 0.0)], [(0.4, 0.1)])),  # another waits on the leg
    ],
)
def test_from_where_the_leg_will_not_do_it_steps_to_where_it_will(
    shapes: list[Shape], stands: Stands
) -> None:
    step = plan(shapes, stands)
    assert isinstance(step, StepPlanned)
    assert step.epoch == 0
    off_m = np.hypot(*(stands.all - np.array([step.target.x_m, step.target.y_m])).T)
    assert off_m.min() >= MISSION.robot_keep_m - 1e-9


def test_shut_in_by_a_wall_it_has_no_step() -> None:
    ring: list[Shape] = [box(-0.6, 0.5, 1.2, 0.1), box(-0.6, -0.6, 1.2, 0.1)]
    ring += [box(-0.6, -0.5, 0.1, 1.0), box(0.5, -0.5, 0.1, 1.0)]
    assert isinstance(plan(ring, stand([(2.0, 0.0)], [])), NoStep)


def test_a_body_that_has_reported_since_and_driven_on_is_in_no_map_though_another_robot_has_gone() -> None:
    """So there are as many robots as before."""
    ring: list[Shape] = [box(-0.6, 0.5, 1.2, 0.1), box(-0.6, -0.6, 1.2, 0.1)]
    ring += [box(-0.6, -0.5, 0.1, 1.0), box(0.5, -0.5, 0.1, 0.2), box(0.5, 0.3, 0.1, 0.2)]
    in_the_door = Circle(centre_m=(0.6, 0.0), radius_m=0.1)
    stands, here, search = stand([(2.0, 0.0)], []), np.zeros(2), Joining(MISSION)
    search.begin(here, epoch=1, robots=(1, 3))
    assert isinstance(plan([*ring, in_the_door], stands, search), NoStep)
    search.begin(here, epoch=2, robots=(1, 3))
    assert isinstance(plan(ring, stands, search), NoStep)
    search.begin(here, epoch=3, robots=(1, 2))
    assert isinstance(plan(ring, stands, search), StepPlanned)


def test_a_search_ends_that_creeps_though_its_way_stays_as_long_as_it_first_seemed(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setattr(joining, "certified_step_to", lambda *_: Step(0.0, GAIN_M))
    stands = stand([(2.0, 0.0)], [])
    view = look_around([], MISSION, revolutions=8)
    search = searching(MISSION, view.position)
    planned = [search.plan(view, stands) for _ in range(9)]
    assert isinstance(planned[0], StepPlanned)
    assert planned[-1] == NoStep("the way to a place is much longer than it seemed")
    search.begin(view.position, epoch=1, robots=(1, 2))
    assert isinstance(search.plan(view, stands), StepPlanned), "in another turn it searches anew"


def test_a_spot_that_the_closest_look_refuses_is_closed_until_the_turn_ends(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """Else a robot goes to and fro between two doors that are both a little too narrow."""
    ways: list[np.ndarray] = []

    def refused_at(_: object, __: object, way: np.ndarray) -> int:
        ways.append(way)
        return len(way) // 2

    for step in ("certified_step_to", "certified_step_to_goal"):
        monkeypatch.setattr(joining, step, lambda *_: None)
    monkeypatch.setattr(joining, "refused_at", refused_at)
    stands = stand([(2.0, 0.0)], [])
    first = look_around([], MISSION)
    search = searching(MISSION, first.position)
    assert isinstance(search.plan(first, stands), LookCloser)
    assert not ways, "what a coarse look refuses is no reason"
    closest = look_around([], MISSION, revolutions=8)
    for _ in range(2):
        assert isinstance(search.plan(closest, stands), NoStep)
    for number, way in enumerate(ways):
        for before in ways[:number]:
            assert np.hypot(*(way - before[len(before) // 2]).T).min() > MISSION.obstacle_keep_m / 4.0
    tried = len(ways)
    search.begin(closest.position, epoch=1, robots=(1,))
    assert isinstance(search.plan(closest, stands), NoStep)
    assert np.array_equal(ways[tried], ways[0]), "in another turn robots stand elsewhere"


# --- places and legs -------------------------------------------------------------------------------

# A hull may stand nearer to a leg than epsilon, since the separation is less.
TIGHT = under("certified", robots=8, robot_radius_m=0.1, separation_m=0.05)
BESIDE = [(0.77, off_m) for off_m in np.linspace(0.25, 0.35, 11).tolist()]


@pytest.mark.parametrize("beside", BESIDE)
@pytest.mark.parametrize("start", [(0.0, 0.0), (0.1, 0.02), (0.2, 0.0)])
def test_a_place_that_it_goes_to_is_one_when_it_gets_there(beside: Place, start: Place) -> None:
    assert goes(start, stand([(0.97, 0.6), beside, (1.0, 0.0)], [(1.25, 0.15)]), TIGHT)[-1] == InPlace()


@pytest.mark.parametrize("beside", [(0.26, 0.0), (0.25, 0.08), (-0.26, 0.0)])
def test_where_obstacles_move_a_hull_beside_the_robot_ahead_refuses_no_place_that_it_goes_to(
    beside: Place,
) -> None:
    """Found behind a door that opens now and then: a robot went to and fro between two such places."""
    mission = replace(TIGHT, obstacle_speed_mps_max=0.6)
    assert goes((-0.016, -0.657), stand([beside, (0.0, 0.0)], []), mission)[-1] == InPlace()


def goes(start: Place, stands: Stands, mission: Mission) -> list[StepPlanned | InPlace | NoStep | LookCloser]:
    """What it plans until it stands, three steps later at most."""
    hulls: list[Shape] = [Circle(centre_m=(x, y), radius_m=0.1) for x, y in stands.all.tolist()]
    joining, at, revolutions = (
        searching(mission, np.array(start)),
        Pose(x_m=start[0], y_m=start[1], heading_rad=0.0),
        1,
    )
    planned: list[StepPlanned | InPlace | NoStep | LookCloser] = []
    while sum(isinstance(each, StepPlanned) for each in planned) <= 3:
        view = look_around(hulls, mission, at, revolutions=revolutions)
        match joining.plan(view, stands):
            case LookCloser() as plan:
                revolutions = closer(mission, len(view.ranges_m)) or 0
            case StepPlanned() as plan:
                at, revolutions = Pose(x_m=plan.target.x_m, y_m=plan.target.y_m, heading_rad=0.0), 1
            case plan:
                return [*planned, plan]
        planned.append(plan)
    return planned
