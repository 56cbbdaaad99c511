import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from msgspec.structs import replace

from protocol.exit_codes import ExitCode
from protocol.frames import Point
from protocol.timeline import Entry, PoseSampled, PromiseBroken
from protocol.timeline.invariants import INVARIANTS
from tests.support.scenes.world_scenarios import scenario
from tests.support.stages.world_stage import Stage
from tests.support.strategies.examples import examples
from world.events import StopAsked
from world.judge.judgement import judge
from world.judge.monitor import Monitor

places = st.builds(lambda x_m, y_m: Point(x_m=x_m, y_m=y_m), st.floats(-3, 5), st.floats(-2, 2))
orders = st.lists(st.tuples(st.integers(1, 3), places, st.integers(0, 60)), max_size=8)


def driven(stage: Stage, plan: list[tuple[int, Point, int]]) -> tuple[Monitor, list[PromiseBroken]]:
    """Drive robots around, watched at each tick by a monitor of the test; returns its violations."""
    watcher = Monitor.of(stage.world.scenario)
    stage.begin()
    placed_m = stage.world.bodies.place_m
    broken = watcher.watch(placed_m, placed_m, t_s=0.0)
    for number, (robot, target, ticks) in enumerate([*plan, (1, Point(x_m=0.0, y_m=0.0), 30)], start=1):
        stage.order(robot, target, number=number)
        for _ in range(ticks):
            before_m = stage.world.bodies.place_m
            stage.tick()
            broken += watcher.watch(before_m, stage.world.bodies.place_m, t_s=stage.world.now_s)
    stage.handle(StopAsked(ExitCode.INTERRUPTED))  # samples all bodies
    return watcher, broken


@settings(deadline=None, max_examples=examples(20))
@given(orders)
def test_every_violation_is_recorded_though_not_every_tick_is_watched(
    plan: list[tuple[int, Point, int]],
) -> None:
    stage = Stage(scenario(fleet={"robots": 3}, drive={"heading_error_rad": 0.0005}))
    _, broken = driven(stage, plan)
    recorded = [entry.record for _, entry in stage.lines if isinstance(entry.record, PromiseBroken)]
    assert [each for each in recorded if each.invariant != "S3"] == broken


@settings(deadline=None, max_examples=examples(10))
@given(orders)
def test_the_log_alone_gives_the_same_minima_as_live(plan: list[tuple[int, Point, int]]) -> None:
    stage = Stage(scenario(fleet={"robots": 3}, drive={"heading_error_rad": 0.0005}))
    watcher, _ = driven(stage, plan)
    from_log = judge(stage.world.scenario, stage.lines)
    assert from_log.least_clearance.distance_m == pytest.approx(watcher.least_clearance.distance_m, abs=1e-6)
    assert from_log.least_separation.distance_m == pytest.approx(
        watcher.least_separation.distance_m, abs=1e-6
    )


MOVING = (
    {
        "id": "walker",
        "shape": "circle",
        "radius_m": 0.3,
        "track": [[0.3, 1.0, -2.0], [2.13, 1.0, 1.0], [3.0, 0.0, 0.0]],
    },
    {
        "id": "door",
        "shape": "polygon",
        "vertices_m": [[0.0, 0.0], [0.5, 0.0], [0.5, 0.2], [0.2, 0.2], [0.2, 1.0], [0.0, 1.0]],
        "track": [[0.0, -2.5, -2.0], [1.01, -2.2, -0.7], [4.0, 0.0, 0.0]],
    },
)


@settings(deadline=None, max_examples=examples(10))
@given(orders)
def test_the_log_alone_finds_the_same_contacts_with_moving_obstacles_as_live(
    plan: list[tuple[int, Point, int]],
) -> None:
    stage = Stage(scenario(*MOVING, fleet={"robots": 3}, drive={"heading_error_rad": 0.0005}))
    watcher, _ = driven(stage, plan)
    from_log, live = judge(stage.world.scenario, stage.lines), watcher.least_moving_clearance
    assert from_log.least_moving_clearance.distance_m == pytest.approx(live.distance_m, abs=1e-6)
    recorded = [entry.record for _, entry in stage.lines if isinstance(entry.record, PromiseBroken)]
    found = [breach.broken for breach in from_log.breaches]
    assert _contacts(found) == _contacts(recorded)


def _contacts(broken: list[PromiseBroken]) -> set[tuple[int, str]]:
    return {(each.robot, each.why) for each in broken if "moving obstacle" in each.why}


def test_a_pose_moved_into_an_obstacle_breaks_a_lawful_log() -> None:
    stage = Stage(scenario())
    stage.begin()
    stage.lead(1, Point(x_m=0.8, y_m=0.0))
    stage.tick(100)
    stage.handle(StopAsked(ExitCode.INTERRUPTED))
    assert judge(stage.world.scenario, stage.lines).violations == dict.fromkeys(INVARIANTS, 0)
    moved = [(source, _moved(entry)) for source, entry in stage.lines]
    violations = judge(stage.world.scenario, moved).violations
    assert (violations["S1"], violations["S3"]) == (1, 1)


def _moved(entry: Entry) -> Entry:
    match entry.record:
        case PoseSampled(robot=1) as pose if entry.t_s == 0.4:
            return replace(entry, record=replace(pose, x_m=1.5, y_m=0.6))
        case _:
            return entry


def test_path_m_is_the_distance_driven_by_all_robots() -> None:
    stage = Stage(scenario())
    stage.begin()
    stage.lead(1, Point(x_m=0.8, y_m=0.0))
    stage.tick(100)
    stage.order(2, Point(x_m=-0.4, y_m=0.0))
    stage.tick(100)
    stage.handle(StopAsked(ExitCode.INTERRUPTED))
    assert judge(stage.world.scenario, stage.lines).path_m == pytest.approx(1.0)


def test_the_log_of_a_run_that_never_began_has_no_violations() -> None:
    judgement = judge(scenario(), [])
    assert (judgement.breaches, judgement.path_m) == ((), 0.0)


def test_a_judge_that_fails_says_why_and_the_world_ends_the_run(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    def fail(*_: object) -> None:
        raise KeyError("no such robot")

    stage = Stage(scenario())
    stage.begin()
    monkeypatch.setattr("world.judge.truth.truth.Truth.hear", fail)
    stage.lead(1, Point(x_m=0.8, y_m=0.0))
    stage.tick(100)
    stage.handle(StopAsked(ExitCode.INTERRUPTED))
    stage.look(after_wall_s=3.0)
    stage.look(after_wall_s=3.0)
    judged = stage.world.judgement
    assert judged is not None
    assert judged.failure is not None
    assert judged.failure.startswith("KeyError: 'no such robot' (test_judgement.py:")
