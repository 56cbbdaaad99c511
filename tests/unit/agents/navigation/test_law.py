"""What becomes of what a law proposes: driven as it is, shortened, or refused with a reason."""

import math
import sys
from collections.abc import Callable

import numpy as np
import pytest

from agents.navigation.law import Law, Seen
from agents.navigation.step import NoStep, Step
from agents.strand.leader import Leader, Wait
from protocol import laws
from protocol.arrays import scan_rays
from protocol.frames import Point
from protocol.timeline import StepPlanned
from tests.support.stages.one_step import ORIGIN, Driven, alone, plan, step_through, under, wall

AHEAD = [wall((1.0, -1.0), (1.0, 1.0))]
MISSION = under("mine", robot_radius_m=0.1, goal=Point(x_m=3.0, y_m=0.0), goal_tolerance_m=0.1)
FREE_M = 1.0 - MISSION.obstacle_keep_m


@pytest.fixture
def use(monkeypatch: pytest.MonkeyPatch) -> Callable[[Law], None]:
    """Have the mission's law be this one."""
    monkeypatch.setattr(laws, "_registered", {})
    return lambda law: laws.register("mine", law)


def test_a_certified_step_is_driven_as_it_is_proposed(use: Callable[[Law], None]) -> None:
    use(lambda _: Step(0.25 + 2.0 * math.pi, 0.5))
    driven = step_through(AHEAD, MISSION)
    assert isinstance(driven, Driven)
    assert driven.planned.law == "mine"
    assert (driven.planned.heading_rad, driven.planned.length_m) == pytest.approx((0.25, 0.5))


@pytest.mark.parametrize("length_m", [0.79, 5.0, 1e300])
def test_a_step_into_a_wall_is_shortened_to_what_is_certified(
    use: Callable[[Law], None], length_m: float
) -> None:
    use(lambda _: Step(0.0, length_m))
    driven = step_through(AHEAD, MISSION)
    assert isinstance(driven, Driven)
    assert driven.planned.length_m == pytest.approx(FREE_M, abs=0.03)
    assert driven.planned.promised_clearance_m is not None
    assert driven.clearance_m >= driven.planned.promised_clearance_m >= MISSION.epsilon_m - 1e-9


class Fickle(float):
    """A number that is another one when it is made plain."""

    def __float__(self) -> float:
        return -5.0


def test_a_number_of_a_law_is_checked_as_it_is_driven(use: Callable[[Law], None]) -> None:
    """Else a step of -5 m is certified as one of 0.5 m: it leads through what is behind."""
    use(lambda _: Step(0.0, Fickle(0.5), cost_to_go_m=1.0))
    refused = step_through([wall((-1.0, -1.0), (-1.0, 1.0))], MISSION)
    assert isinstance(refused, NoStep)
    assert "got 0.0 rad and -5.0 m" in refused.reason


def frees_walls(seen: Seen) -> None:
    seen.walls.keep_m.setflags(write=True)
    seen.walls.keep_m[:] = 0.0


def forgets_walls(seen: Seen) -> None:
    for each in vars(seen.walls.seen_from(seen.position)).values():
        each[:] = 0.0


def stands_elsewhere(seen: Seen) -> None:
    seen.position.setflags(write=True)
    seen.position[0] -= 0.5


def wants_less(seen: Seen) -> None:
    object.__setattr__(seen.walls, "keep_m", 0.0 * seen.walls.keep_m)


@pytest.mark.parametrize(
    "change",
    [frees_walls, forgets_walls, stands_elsewhere, wants_less],
    ids=lambda each: each.__name__,
)
def test_what_a_law_does_to_what_it_is_given_certifies_nothing(
    use: Callable[[Law], None], change: Callable[[Seen], None]
) -> None:
    """Some drove 0.07 m into the wall."""

    def law(seen: Seen) -> Step:
        change(seen)
        return Step(0.0, 0.95)

    use(law)
    driven = step_through(AHEAD, MISSION)
    assert isinstance(driven, Driven)
    assert driven.clearance_m >= MISSION.epsilon_m - 1e-9
    assert driven.planned.promised_clearance_m == pytest.approx(driven.clearance_m, abs=0.03)


def test_nor_can_it_turn_the_rays_which_all_scans_share() -> None:
    with pytest.raises(ValueError, match="cannot set WRITEABLE"):
        scan_rays(360).setflags(write=True)


@pytest.mark.parametrize("room_m", [0.04, 0.08])
def test_a_step_of_which_one_centimetre_or_more_is_certified_is_driven(
    use: Callable[[Law], None], room_m: float
) -> None:
    use(lambda _: Step(0.0, 1.0))
    far_m = MISSION.obstacle_keep_m + room_m
    driven = step_through([wall((far_m, -1.0), (far_m, 1.0))], MISSION)
    assert isinstance(driven, Driven)
    assert 0.01 <= driven.planned.length_m <= room_m


def test_a_step_of_which_nothing_is_certified_is_refused(use: Callable[[Law], None]) -> None:
    use(lambda seen: seen.step_to((1.0, 0.0)))
    refused = step_through([wall((0.2, -1.0), (0.2, 1.0))], MISSION)
    assert isinstance(refused, NoStep)
    assert refused.reason.startswith("the law mine proposes 1.000 m at 0.000 rad, of which 0.00")


def test_a_law_that_shortens_its_steps_itself_is_refused_the_same_but_where_it_tells_the_cost_to_go(
    use: Callable[[Law], None],
) -> None:
    free_m = list[float]()

    def law(seen: Seen, cost_m: float | None = None) -> Step:
        free_m.append(float(seen.free_m([0.0])[0]))
        return Step(0.0, free_m[-1], cost_to_go_m=cost_m)

    near_m = MISSION.obstacle_keep_m + 0.028  # the scan certifies no more than 1 cm
    near = [wall((near_m, -1.0), (near_m, 1.0))]
    use(lambda seen: law(seen, 3.0))
    assert isinstance(step_through(near, MISSION), Driven)
    use(law)
    refused = step_through(near, MISSION)
    assert 0.0 < free_m[-1] < 0.01
    assert refused == NoStep(
        f"the law mine proposes {free_m[-1]:.3f} m at 0.000 rad, of which {free_m[-1]:.4f} m are certified"
    )


def test_without_a_goal_too_a_step_is_shortened_and_none_where_it_is_open_ends_the_crossing(
    use: Callable[[Law], None],
) -> None:
    mission = under("mine", robot_radius_m=0.1)
    use(lambda _: Step(0.0, 5.0))
    driven = step_through(AHEAD, mission)
    assert isinstance(driven, Driven)
    assert driven.planned.length_m == pytest.approx(FREE_M, abs=0.03)
    use(lambda _: None)
    assert step_through(AHEAD, mission) == NoStep("the law mine proposes no step from here")
    assert not isinstance(step_through([], mission), NoStep)
    use(lambda _: Step(math.nan, 1.0))
    assert isinstance(step_through([], mission), NoStep)  # a law that fails has not crossed


def raising(_: Seen) -> Step:
    raise RuntimeError("no idea")


class UnspeakableError(Exception):
    """An error that cannot say what it is."""

    def __str__(self) -> str:
        raise RuntimeError


def raising_an_unspeakable_error(_: Seen) -> Step:
    raise UnspeakableError


class PanicException(BaseException):
    """What a panic of a library in Rust is in Python."""


def panicking(_: Seen) -> Step:
    raise PanicException("index out of bounds")


def raising_half_a_character(_: Seen) -> Step:
    raise RuntimeError("half of one: \ud83d")


@pytest.mark.parametrize(
    ("law", "why"),
    [
        (raising, r"RuntimeError: no idea \(test_law.py:\d+ raising, test_law.py:\d+ counted\)$"),
        (raising_an_unspeakable_error, "UnspeakableError: .*raising_an_unspeakable_error"),
        (raising_half_a_character, r"half of one: \\ud83d"),
        (lambda _: sys.exit("enough"), "SystemExit: enough"),
        (panicking, "PanicException: index out of bounds"),
        (lambda _: Step(math.nan, 1.0), "got nan rad and 1.0 m$"),
        (lambda _: Step(0.0, math.inf), "got 0.0 rad and inf m"),
        (lambda _: Step(0.0, -1.0), "got 0.0 rad and -1.0 m"),
        (lambda _: Step("east", 1.0), "could not convert string"),  # type: ignore[arg-type] # not every user has types
        (lambda _: Step(0.0, 1.0, gap=7), "gap 7 of 0"),
        (lambda _: Step(0.0, 1.0, cost_to_go_m=math.nan), "no cost nan"),
        (lambda _: (0.0, 1.0), "it proposes no step but tuple"),
        (lambda _, __: None, "TypeError: .* missing 1 required positional argument"),
        (lambda seen: np.put(seen.ranges_m, 0, 9.0), "read-only"),
        (lambda seen: np.put(seen.walls.keep_m, 0, 0.0), "read-only"),
        (lambda seen: np.put(seen.remembered, 0, 0.0), "read-only"),
        (lambda seen: np.put(seen.obstacles[0].tangent_1, 0, 0.0), "read-only"),
        (lambda seen: np.put(seen.position, 0, 0.0), "read-only"),
    ],
)
def test_a_law_that_fails_is_refused_at_once_with_the_reason(
    use: Callable[[Law], None], law: Law, why: str
) -> None:
    times = list[Seen]()

    def counted(seen: Seen) -> Step | str | None:
        times.append(seen)
        return law(seen)

    use(counted)
    with laws.overheard("mine", lambda _: None):  # one more call that is not the user's
        refused = step_through(AHEAD, MISSION)
    assert isinstance(refused, NoStep)
    assert len(times) == 1
    refused.reason.encode()  # else no timeline can hold it
    with pytest.raises(ValueError, match=f"^the law mine failed: .*{why}"):
        raise ValueError(refused.reason)


def test_numbers_of_numpy_become_plain_ones(use: Callable[[Law], None]) -> None:
    use(lambda _: Step(np.float64(0.1), np.float64(0.3), None, np.float64(2.0)))
    driven = step_through(AHEAD, MISSION)
    assert isinstance(driven, Driven)
    planned = driven.planned
    assert {type(each) for each in (planned.heading_rad, planned.length_m, planned.cost_to_go_m)} == {float}


@pytest.mark.parametrize(
    ("said", "reason"),
    [(None, "the law mine proposes no step from here"), ("no!", "no!"), ("\ud83d?", r"\ud83d?")],
)
def test_a_law_that_proposes_nothing_is_asked_again_only_from_a_closer_look_and_when_the_strand_stands(
    use: Callable[[Law], None], said: str | None, reason: str
) -> None:
    rays = list[int]()

    def law(seen: Seen) -> str | None:
        rays.append(len(seen.ranges_m))
        return said

    use(law)
    leader = Leader(MISSION, ORIGIN)
    assert plan(leader, AHEAD, MISSION, alone(), settled=False) == Wait()
    assert rays == sorted(set(rays))
    assert len(rays) > 1
    assert plan(leader, AHEAD, MISSION, alone()) == NoStep(reason)


def test_a_way_that_the_scan_permits_is_not_closed_where_the_law_does_not_want_it(
    use: Callable[[Law], None],
) -> None:
    costs_m = list[float]()

    def law(seen: Seen) -> str:
        costs_m.append(float(seen.cost_to_go_m(seen.position[None])[0]))
        return "no, thanks"

    use(law)
    assert step_through([], MISSION) == NoStep("no, thanks")
    assert len(costs_m) < 5
    assert set(costs_m) == {costs_m[0]}


def test_chance_is_the_same_for_the_same_sight_and_differs_from_step_to_step(
    use: Callable[[Law], None],
) -> None:
    seeds = list[int]()

    def law(seen: Seen) -> Step:
        seeds.append(seen.seed)
        return Step(0.0, 0.1)

    use(law)
    one, other = Leader(MISSION, ORIGIN), Leader(MISSION, ORIGIN)
    for leader in (one, one, other):
        assert isinstance(plan(leader, AHEAD, MISSION, alone()), StepPlanned)
    assert seeds[0] == seeds[2] != seeds[1]
