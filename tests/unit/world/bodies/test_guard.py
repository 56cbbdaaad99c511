"""The guard, held against the monitor."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from protocol.fence import Bearing, Cause, Epoch, Fence, May, Raise, Turn
from protocol.frames import Point, Pose
from protocol.mission import Bounds
from protocol.timeline import PromiseBroken
from protocol.wire.messages import Drive
from tests.support.scenes.world_scenarios import SPACING_M, scenario
from world.bodies.arena import Arena
from world.bodies.bodies import Bodies, Moves
from world.bodies.guard import SMALL_FLEET, Guard
from world.geometry.movers import Movers
from world.judge.monitor import Monitor, Promises
from world.scenario.sections import DriveSection

GROUND = scenario().ground  # a circle at (1.5, 0.6) of radius 0.3, and a square from (2, -1.5) to (3, -0.5)
ALL = Fence(epoch=Epoch(generation=1, robot=1, life=7), turn=4, may=May.ALL, robot=1, members=3)
TICK_S = 0.02
quietly = settings(deadline=None, max_examples=20)  # a case is 100s of ticks


class Watched:
    """Bodies, with a guard and a monitor that look at every tick."""

    def __init__(
        self,
        *places_m: tuple[float, float],
        separation_m: float = 0.05,
        bounds: Bounds | None = None,
        speed_mps: float = 0.5,
    ) -> None:
        drive = DriveSection(
            speed_mps=speed_mps,
            speed_mps_min=0.05,
            speed_mps_max=100.0,
            turn_rate_radps=9.0,
            heading_error_rad=0.0,
        )
        self.speed_mps = speed_mps
        starts = [Pose(x_m=x_m, y_m=y_m, heading_rad=0.0) for x_m, y_m in places_m]
        self.bodies = Bodies(starts, drive, [np.random.default_rng(row) for row in range(len(starts))])
        promises = Promises(
            radius_m=0.1, clearance_m_required=0.08, separation_m_required=separation_m, bounds=bounds
        )
        self.guard = Guard(promises, GROUND, len(starts))
        self.monitor = Monitor(GROUND, Movers.of(()), promises)
        self.monitor.watch(self.bodies.place_m, self.bodies.place_m, t_s=0.0)
        self.ticks = 0

    def drive(self, row: int, x_m: float, y_m: float) -> None:
        """Order a body to a place."""
        order = Drive(
            number=self.bodies[row].ordered + 1,
            basis_s=0.0,
            target=Point(x_m=x_m, y_m=y_m),
            speed_mps=self.speed_mps,
            bearing=Bearing(epoch=ALL.epoch, turn=ALL.turn, life=7),
            step=0,
            reach_m=0.0,
        )
        self.bodies.hear(row, order, ALL, now_s=0.0)

    def tick(self) -> tuple[bool, list[str]]:
        """Whether the guard finds the moves of the next tick safe, and what the monitor says of them."""
        starts_m = self.bodies.place_m
        moves: Moves = self.bodies.tick(now_s=0.0, tick_s=TICK_S)
        self.ticks += 1
        is_safe = self.guard.are_safe(self.bodies, moves)
        broken = self.monitor.watch(starts_m, self.bodies.place_m, t_s=self.ticks * TICK_S)
        return is_safe, [each.invariant for each in broken]

    def all_ticks(self, ticks: int = 400) -> list[tuple[bool, list[str]]]:
        """Ticks until all stand."""
        found: list[tuple[bool, list[str]]] = []
        while self.bodies.any_moves and len(found) < ticks:
            found.append(self.tick())
        return found


places = st.tuples(st.floats(-2.0, 4.0), st.floats(-2.0, 2.0))


@quietly
@given(st.lists(places, min_size=3, max_size=3), st.lists(places, min_size=3, max_size=3))
def test_what_the_guard_finds_safe_breaks_no_promise(
    starts: list[tuple[float, float]], ends: list[tuple[float, float]]
) -> None:
    bounds = Bounds(x_m_min=-2.0, y_m_min=-2.0, x_m_max=4.0, y_m_max=2.0)
    fleet = Watched(*starts, bounds=bounds)
    for row, end in enumerate(ends):
        fleet.drive(row, *end)
    for is_safe, broken in fleet.all_ticks():
        assert not (is_safe and broken)
        if not fleet.monitor.is_calm:
            break  # a return to what is promised is for the monitor


@quietly
@given(st.integers(0, 2**32))
def test_in_a_large_fleet_no_pair_is_overlooked(seed: int) -> None:
    chance = np.random.default_rng(seed)
    count = SMALL_FLEET + 14
    grid = [(-3.0 - 0.4 * (row % 6), -4.0 - 0.4 * (row // 6)) for row in range(count)]
    fleet = Watched(*grid)
    for row in chance.choice(count, 8, replace=False).tolist():
        fleet.drive(row, *chance.uniform((-8.0, -8.0), (-3.0, -4.0)).tolist())
    for is_safe, broken in fleet.all_ticks():
        assert not (is_safe and broken)
        if not fleet.monitor.is_calm:
            break


def test_a_body_that_drives_further_in_a_tick_than_others_were_looked_for_is_not_safe() -> None:
    elsewhere = [(-20.0 - row, 0.0) for row in range(SMALL_FLEET)]
    fleet = Watched((-8.0, 0.0), (-6.1, 0.0), *elsewhere, speed_mps=99.0)
    fleet.drive(0, 90.0, 0.0)
    assert fleet.tick() == (False, ["S2"])


@pytest.mark.parametrize(
    ("from_m", "to_m", "others", "is_safe"),
    [
        ((0.0, 0.0), (1.0, -0.3), [], True),  # on open ground
        ((0.0, 0.6), (1.0, 0.6), [], True),  # towards the circle, and stops in time
        ((0.0, 0.6), (1.1, 0.6), [], False),  # too near to it
        ((0.0, 1.085), (3.0, 1.085), [], True),  # past it: 5 mm more than promised
        ((0.0, 1.075), (3.0, 1.075), [], False),  # 5 mm less
        ((0.0, 0.0), (-1.85, 0.0), [], True),
        ((0.0, 0.0), (-1.95, 0.0), [], False),  # beyond the bounds
        ((0.0, 0.0), (1.0, 0.0), [(0.5, 0.255)], True),  # past another body
        ((0.0, 0.0), (1.0, 0.0), [(0.5, 0.245)], False),
    ],
)
def test_a_drive_is_safe_as_long_as_it_keeps_what_is_promised(
    from_m: tuple[float, float], to_m: tuple[float, float], others: list[tuple[float, float]], is_safe: bool
) -> None:
    bounds = Bounds(x_m_min=-2.0, y_m_min=-2.0, x_m_max=4.0, y_m_max=2.0)
    fleet = Watched(from_m, *others, bounds=bounds)
    fleet.drive(0, *to_m)
    found = fleet.all_ticks()
    assert all(safe for safe, _ in found) is is_safe
    assert any(broken for _, broken in found) is not is_safe


def test_two_bodies_that_drive_in_file_are_safe_and_two_that_meet_are_not() -> None:
    file = Watched((0.0, 0.0), (-0.26, 0.0))
    file.drive(0, -1.0, -1.0)
    file.drive(1, -1.26, -1.0)
    assert all(safe for safe, _ in file.all_ticks())
    pair = Watched((0.0, 0.0), (-1.0, 0.0))
    pair.drive(0, -1.0, 0.0)
    pair.drive(1, 0.0, 0.0)
    found = pair.all_ticks()
    unsafe = [number for number, (safe, _) in enumerate(found) if not safe]
    broken = [number for number, (_, invariants) in enumerate(found) if invariants]
    assert broken == [unsafe[0]]


def test_a_body_that_has_driven_so_far_in_one_tick_is_not_overlooked_in_the_next() -> None:
    elsewhere = [(-20.0 - row, 0.0) for row in range(SMALL_FLEET)]
    fleet = Watched((-8.0, 0.0), (-6.4, 0.3), *elsewhere, speed_mps=90.0)
    fleet.drive(0, -6.4, 0.0)
    assert fleet.tick() == (False, [])
    fleet.drive(1, -6.4, 0.2)
    assert fleet.all_ticks()[-1] == (False, ["S2"])


class Queue:
    """A large fleet in a row, in the world's own way; under ALL."""

    def __init__(self) -> None:
        fleet = {"robots": SMALL_FLEET + 4}
        self.arena = Arena(scenario(fleet=fleet, bounds={"x_m_min": -40.0}), seed=1)
        self.arena.place()
        epoch = Epoch(generation=1, robot=1, life=7)
        self.arena.put(1, Raise(epoch=epoch, cause=Cause.START))
        self.arena.put(1, Turn(fence=Fence(epoch=epoch, turn=1, may=May.ALL, robot=1, life=7, members=20)))

    def drive(self, robot: int, *ways_m: tuple[float, float]) -> list[tuple[int, int | None]]:
        """Let a robot drive there, from place to place; returns the pairs that come too near."""
        arena, near = self.arena, list[tuple[int, int | None]]()
        for x_m, y_m in ways_m:
            number, fence = arena.bodies[robot - 1].ordered + 1, arena.fence
            while arena.bodies[robot - 1].finished_number < number:
                order = Drive(
                    number=number,
                    basis_s=arena.now_s,
                    target=Point(x_m=x_m, y_m=y_m),
                    speed_mps=0.5,
                    bearing=Bearing(epoch=fence.epoch, turn=fence.turn, life=7),
                    step=0,
                    reach_m=0.0,
                )
                arena.order(robot, order)
                broken = [note.record for note in arena.tick()[0] if isinstance(note.record, PromiseBroken)]
                near += [(each.robot, each.other) for each in broken]
        return near


def test_a_body_that_came_near_while_a_promise_was_broken_is_not_overlooked_afterwards() -> None:
    queue, tenth_m, last_m = Queue(), -9 * SPACING_M, -19 * SPACING_M
    assert queue.drive(1, (-0.33, 0.0)) == [(1, 2)]
    assert queue.drive(20, (last_m, -1.0), (tenth_m, -1.0), (tenth_m, -0.35)) == []
    assert queue.drive(1, (-0.3, 0.0)) == []
    assert queue.drive(10, (tenth_m, -0.2)) == [(10, 20)]
