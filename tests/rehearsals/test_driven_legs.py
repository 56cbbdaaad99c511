"""Drive errors do not add up: not over views, and not over steps beside the bounds (docs/strand.md)."""

import math
from collections.abc import Callable
from pathlib import Path
from unittest.mock import Mock

import numpy as np
import pytest

from clew.rehearsal.rehearsal import Rehearsal
from protocol.errors import UsageError
from protocol.faults.plan import Plan
from protocol.faults.rules import Drop, Kill, Restart
from protocol.fence import Cause
from protocol.keys import WORLD
from protocol.timeline import ViewProposed
from world.bodies import arena
from world.chance import stream
from world.judge.ending import Ending
from world.judge.judgement import judge
from world.scenario.scenario import load

ROBOTS, LEG_M = 4, 0.98
HEADING_ERROR_RAD, RANGE_M = 0.01, 1.0


def drives(heading_error_rad: float) -> str:
    """The sections of a scenario that say how robots see and drive."""
    return f"""
[sensor]
directions = 360
range_m_max = {RANGE_M}
[drive]
speed_mps = 0.3
speed_mps_min = 0.05
speed_mps_max = 1.0
turn_rate_radps = 50.0
heading_error_rad = {heading_error_rad}
[time]
time_s_max = 120.0
"""


ALONG_THE_BOUNDS = f"""
name = "along-the-bounds"
[fleet]
robots = {ROBOTS}
robot_radius_m = 0.1
separation_m = 0.084
link_length_m_max = 2.0
places = {[[-LEG_M * rank, 0.0, 1.0] for rank in range(ROBOTS)]}
[law]
epsilon_m = 0.1
mu0_m = 0.042
[goal]
at_m = [12.0, 0.0]
tolerance_m = 0.1
[bounds]
x_m_min = -20.0
y_m_min = -0.1421
x_m_max = 20.0
y_m_max = 3.0
{drives(HEADING_ERROR_RAD)}
"""


def adverse(off: Callable[[float, float], float]) -> Callable[[int, str], np.random.Generator]:
    """As drawn, but for an adversary's drives: each is off by what it chooses between two limits."""

    def drawn_or_chosen(seed: int, purpose: str) -> np.random.Generator:
        drawn = stream(seed, purpose)
        if not purpose.startswith("drive/"):
            return drawn
        adversary = Mock(spec=drawn)
        adversary.uniform.side_effect = off
        return adversary

    return drawn_or_chosen


errors = adverse(lambda low, _high: low)
"""Each heading is as far off to the right as it may be."""


def test_drive_errors_do_not_add_up_from_view_to_view(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """In each view the next robot has just come to where the first one stood at the start."""
    monkeypatch.setattr(arena, "stream", errors)
    (path := tmp_path / "along-the-bounds.toml").write_text(ALONG_THE_BOUNDS)
    scenario = load(str(path))
    rehearsal, comes, lowest_m = Rehearsal(scenario, 1), 2, 0.0
    for now_s in rehearsal.ticks():
        places = rehearsal.world.bodies.places
        lowest_m = min(lowest_m, *(y_m for _, y_m in places))
        if comes <= ROBOTS and places[comes - 1][0] >= -0.004:
            comes += 1
            rule = Restart(name=f"view-{comes}", from_s=now_s, target=WORLD)
            rehearsal.turn_to(Plan(name="views", rules=(rule,)))
    assert comes > ROBOTS
    assert judge(scenario, rehearsal.entries).breaches == ()
    assert -lowest_m <= HEADING_ERROR_RAD * RANGE_M, "what one drive may be off"
    assert rehearsal.world.ending is Ending.ARRIVED


QUEUE, APART_M, MOVED_M, VIEWS = 5, 0.93, 0.3, 4
SHORT_QUEUE = ALONG_THE_BOUNDS.replace(
    str([[-LEG_M * rank, 0.0, 1.0] for rank in range(ROBOTS)]),
    str([[-APART_M * rank, 0.0, 1.0] for rank in range(QUEUE)]),
)
AT_THE_BOUNDS = SHORT_QUEUE.replace("y_m_min = -0.1421", "y_m_min = -0.1").replace(
    "at_m = [12.0, 0.0]", "at_m = [4.0, 0.0]"
)


def test_nor_do_they_where_in_each_view_all_robots_have_new_lives_and_know_no_driven_leg(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Each view lays the path through where bodies stand; here that came nearer to the bounds each time."""
    monkeypatch.setattr(arena, "stream", errors)
    (path := tmp_path / "at-the-bounds.toml").write_text(AT_THE_BOUNDS)
    scenario = load(str(path), robots=QUEUE)
    rehearsal, views, tail_m = Rehearsal(scenario, 1), 0, -APART_M * (QUEUE - 1)
    for now_s in rehearsal.ticks():
        x_m, _ = rehearsal.world.bodies.places[-1]
        if views < VIEWS and x_m >= tail_m + MOVED_M:
            views, tail_m = views + 1, x_m
            names = [f"r{robot}" for robot in range(1, QUEUE + 1)]
            rules = (Restart(name=f"view-{views}-{name}", from_s=now_s, target=name) for name in names)
            rehearsal.turn_to(Plan(name="lives", rules=tuple(rules)))
    assert views == VIEWS
    assert judge(scenario, rehearsal.entries).breaches == ()
    assert rehearsal.world.ending is Ending.ARRIVED


SLOT = f"""
name = "slot-along-the-bounds"
[fleet]
robots = 1
robot_radius_m = 0.1
separation_m = 0.05
link_length_m_max = 2.0
places = [[0.0, 0.0, 0.0]]
[law]
epsilon_m = 0.1
mu0_m = 0.0205
[goal]
at_m = [9.0, -0.02]
tolerance_m = 0.1
[bounds]
x_m_min = -2.0
y_m_min = -0.1206
x_m_max = 11.0
y_m_max = 3.0
{drives(0.005)}
[[obstacle]]
shape = "polygon"
vertices_m = [[0.3, 0.21], [8.5, 0.21], [8.5, 3.0], [0.3, 3.0]]
"""


def test_drive_errors_do_not_add_up_from_step_to_step(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """The only way leads along the bounds, and each drive is off towards them."""
    monkeypatch.setattr(arena, "stream", errors)
    (path := tmp_path / "slot.toml").write_text(SLOT)
    scenario = load(str(path))
    rehearsal = Rehearsal(scenario, 1)
    for _ in rehearsal.ticks():
        pass
    assert judge(scenario, rehearsal.entries).breaches == ()
    assert rehearsal.world.ending is Ending.ARRIVED


BETWEEN_THE_BOUNDS = (
    SHORT_QUEUE.replace("y_m_max = 3.0", "y_m_max = {side_m}")
    .replace("y_m_min = -0.1421", "y_m_min = -{side_m}")
    .replace("at_m = [12.0, 0.0]", "at_m = [0.0, 0.0]")
)


def test_robots_that_close_up_between_two_sides_of_the_bounds_stay_inside(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """The leader has no room for a step and is at the goal; those behind drive along the path."""
    monkeypatch.setattr(arena, "stream", errors)
    path = tmp_path / "between.toml"
    path.write_text(BETWEEN_THE_BOUNDS.replace("{side_m}", "0.105"))
    with pytest.raises(UsageError, match=r"bounds\.y_m_min: must be <= y_m_max - 2 "):
        load(str(path), robots=QUEUE)  # robots came out of such bounds by half a drive's error
    path.write_text(BETWEEN_THE_BOUNDS.replace("{side_m}", "0.1105"))
    scenario = load(str(path), robots=QUEUE)
    rehearsal = Rehearsal(scenario, 1)
    for _ in rehearsal.ticks():
        pass
    assert judge(scenario, rehearsal.entries).breaches == ()
    assert rehearsal.world.ending is Ending.ARRIVED


EPSILON_M, MU0_M, RADIUS_M = 0.1, 0.0402, 0.1
POST_M, POST_RADIUS_M = (-0.07, 0.241), 0.05
TIMES = 6

DEAD_END = f"""
name = "dead-end-beside-a-post"
[fleet]
robots = 2
robot_radius_m = {RADIUS_M}
separation_m = 0.084
link_length_m_max = 2.0
places = [[0.95, 0.0, 0.0], [0.0, 0.0, 0.0]]
[law]
epsilon_m = {EPSILON_M}
mu0_m = {MU0_M}
[goal]
at_m = [6.0, 0.0]
tolerance_m = 0.1
{drives(HEADING_ERROR_RAD).replace("120.0", "900.0")}
[[obstacle]]
shape = "circle"
centre_m = {list(POST_M)}
radius_m = {POST_RADIUS_M}
[[obstacle]]
shape = "polygon"
vertices_m = [[2.3, -0.7], [2.4, -0.7], [2.4, 0.7], [2.3, 0.7]]
[[obstacle]]
shape = "polygon"
vertices_m = [[0.7, 0.35], [2.4, 0.35], [2.4, 0.7], [0.7, 0.7]]
[[obstacle]]
shape = "polygon"
vertices_m = [[0.7, -0.35], [2.4, -0.35], [2.4, -0.7], [0.7, -0.7]]
"""


def test_drive_errors_do_not_add_up_where_a_tail_comes_back_and_has_a_new_life_each_time(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """The way back out of the dead end ends where the tail stood, and each drive is off towards a post there.

    Its neighbour does not hear that it may come up, so that the last drive is a long one.
    """
    comes_back = False

    monkeypatch.setattr(arena, "stream", adverse(lambda low, _high: low if comes_back else 0.0))
    (path := tmp_path / "dead-end.toml").write_text(DEAD_END)
    scenario = load(str(path))
    rehearsal, times, is_cut = Rehearsal(scenario, 1), 0, False
    for now_s in rehearsal.ticks():
        (ahead_x_m, _), (x_m, y_m) = rehearsal.world.bodies.places
        comes_back = comes_back or x_m > 1.2
        if comes_back and not is_cut and ahead_x_m < 0.96 and x_m < 0.9:
            is_cut = True
            rule = Drop(name=f"cut-{times}", sender=("r2",), receiver=("r1",), kinds=("ahead",))
            rehearsal.turn_to(Plan(name="cut", rules=(rule,)))
        if comes_back and x_m < 0.02 and not rehearsal.world.bodies.any_moves:
            times, comes_back, is_cut = times + 1, False, False
            off_m = math.dist((x_m, y_m), POST_M) - POST_RADIUS_M - RADIUS_M
            assert off_m >= EPSILON_M - MU0_M, f"it has come back {times} times"
            lives = (Restart(name=f"{robot}-{times}", from_s=now_s, target=robot) for robot in ("r1", "r2"))
            rehearsal.turn_to(Plan(name="lives", rules=tuple(lives)))
        if times == TIMES:
            break
    assert times == TIMES
    assert judge(scenario, rehearsal.entries).breaches == ()


FRONTS, FRONT_RADIUS_M, FRONT_APART_M = 13, 0.3, 0.8
HIDDEN_RADIUS_M, HIDDEN_RAD = 0.02, math.radians(-66.0)
HIDDEN_OFF_M = FRONT_RADIUS_M + EPSILON_M + HIDDEN_RADIUS_M + 1e-9
HIDDEN_M = (HIDDEN_OFF_M * math.cos(HIDDEN_RAD), HIDDEN_OFF_M * math.sin(HIDDEN_RAD))
LEADS_ON_M = 3.2

BEFORE_A_HIDDEN_POST = f"""
name = "before-a-hidden-post"
obstacle_speed_mps_max = OBSTACLE_SPEED_MPS
[fleet]
robots = {FRONTS}
robot_radius_m = {FRONT_RADIUS_M}
separation_m = 0.084
link_length_m_max = 20.0
places = {[[-FRONT_APART_M * rank, 0.0, 1.0] for rank in range(FRONTS)]}
[law]
epsilon_m = {EPSILON_M}
mu0_m = 0.04
[goal]
at_m = [1.0, 40.0]
tolerance_m = 0.1
[sensor]
directions = 360
range_m_max = 1.72
[drive]
speed_mps = 1.4
speed_mps_min = 0.05
speed_mps_max = 5.0
turn_rate_radps = 50.0
heading_error_rad = 0.0058
[time]
time_s_max = 900.0
[[obstacle]]
shape = "circle"
centre_m = {list(HIDDEN_M)}
radius_m = {HIDDEN_RADIUS_M}
"""


def lets_nobody_come(rehearsal: Rehearsal, told: int) -> bool:
    """Whether a leader has found since so many entries that it began too near to something."""
    records = (entry.record for _, entry in rehearsal.entries[told:])
    return any(isinstance(each, ViewProposed) and each.cause is Cause.MISFIT for each in records)


@pytest.mark.parametrize(
    "obstacle_speed_mps",
    [
        pytest.param(0.0, id="nothing moves", marks=pytest.mark.long),
        pytest.param(0.01, id="obstacles may move"),
    ],
)
def test_nor_where_each_leader_is_lost_and_the_robot_behind_it_stands_where_it_began(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, obstacle_speed_mps: float
) -> None:
    """The first robot's hull hides a post beyond its place from the next one, which comes there by a new leg.

    Where obstacles may move, a newer scan permits each drive there; but it keeps off contact alone.

    Each leader drives on and dies once the next robot has come to where it began; all behind have new lives.
    The last drive there is a long one, since that robot does not hear that it may come up; it is off towards
    the post. The eleventh that came so was too near to it, while leaders did not look how they begin.
    """
    is_last = False

    monkeypatch.setattr(arena, "stream", adverse(lambda low, high: low if is_last else high))
    (path := tmp_path / "hidden-post.toml").write_text(
        BEFORE_A_HIDDEN_POST.replace("OBSTACLE_SPEED_MPS", str(obstacle_speed_mps))
    )
    scenario = load(str(path))
    rehearsal, front, is_cut, begins_s = Rehearsal(scenario, 1), 1, False, 0.0
    is_found, told = False, 0
    stood = rehearsal.world.bodies.places
    for now_s in rehearsal.ticks():
        places = rehearsal.world.bodies.places
        if now_s <= begins_s:
            stood = places
            continue
        led_on_m, (x_m, _) = math.hypot(*places[front - 1]), places[front]
        if not is_cut and not is_last and math.dist(places[front], stood[front]) > 0.015:
            is_cut = True
            names = (f"r{front}",), (f"r{front + 1}",)
            rule = Drop(name=f"cut-{front}", sender=names[0], receiver=names[1], kinds=("ahead",))
            rehearsal.turn_to(Plan(name="cut", rules=(rule,)))
        if is_cut and led_on_m > LEADS_ON_M:
            is_cut, is_last = False, True
            rehearsal.turn_to(Plan(name="none", rules=()))
        if is_last and x_m > -0.003:
            lost = Kill(name=f"lost-{front}", from_s=now_s, target=f"r{front}")
            stops = Restart(name=f"stops-{front}", from_s=now_s, target=WORLD)
            lives = (
                Restart(name=f"r{robot}-{front}", from_s=now_s, target=f"r{robot}")
                for robot in range(front + 2, FRONTS + 1)
            )
            rehearsal.turn_to(Plan(name="lives", rules=(lost, stops, *lives)))
            front, is_last, begins_s = front + 1, False, now_s + 0.1
        is_found, told = lets_nobody_come(rehearsal, told), len(rehearsal.entries)
        if front == FRONTS or is_found or now_s > 60.0:
            break
    assert front > 8, "as many have come to where the first one stood"
    assert is_found, "then one of them lets nobody come there"
    assert judge(scenario, rehearsal.entries).breaches == ()
