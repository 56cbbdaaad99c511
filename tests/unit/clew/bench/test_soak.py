"""What counts as growth in a soak, and what fails it."""

import itertools

import pytest
from msgspec.structs import replace

from clew.bench.result import all_met
from clew.bench.soak import PARTS, Look, Probe, Soak, endless_queue, figures, targets
from clew.bench.usage import Usage

LOOKS = 30


def look(at_s: float, *, pss_mb: float = 20.0, files: float = 20.0, sessions: int = 6) -> Look:
    used = {part: Usage(processes=1, pss_mb=pss_mb, files=files) for part in PARTS}
    return Look(at_s=at_s, used=used, sessions=sessions)


def soaked(**changed: object) -> Soak:
    sound = Soak(
        robots=5,
        asked_s=60.0,
        soaked_s=60.0,
        restarts=30,
        looks=tuple(look(2.0 * number) for number in range(LOOKS)),
        probes=(Probe(at_s=0.0, took_s=0.01), Probe(at_s=5.0, took_s=0.1)),
        missing=0,
        violations=0,
        said="the run was told to end",
        load=(0.0, 1.0),
    )
    return replace(sound, **changed)


def missed(soak: Soak) -> list[str]:
    return [each.name for each in figures(soak) if each.met is False]


def growing(**per_look: float) -> tuple[Look, ...]:
    """Looks in which these values grow, each by so much from one look to the next."""
    more = {"pss_mb": 0.0, "files": 0.0, "sessions": 0.0} | per_look
    return tuple(
        look(
            2.0 * number,
            pss_mb=20.0 + number * more["pss_mb"],
            files=20.0 + number * more["files"],
            sessions=round(6 + number * more["sessions"]),
        )
        for number in range(LOOKS)
    )


def test_a_fleet_that_stays_as_it_is_all_met() -> None:
    assert missed(soaked()) == []
    assert all_met(figures(soaked()))


@pytest.mark.parametrize(
    ("looks", "first_missed", "count"),
    [
        (growing(pss_mb=0.3), "memory of a robot, growth", len(PARTS)),
        (growing(files=0.3), "descriptors of a robot, growth", len(PARTS)),
        (growing(sessions=1), "sessions at the router, growth", 1),
    ],
)
def test_what_grows_beyond_its_bound_fails(looks: tuple[Look, ...], first_missed: str, count: int) -> None:
    names = missed(soaked(looks=looks))
    assert (names[0], len(names)) == (first_missed, count)


def test_a_little_memory_more_and_all_that_comes_in_the_first_third_is_no_growth() -> None:
    warm = tuple(look(2.0 * number, pss_mb=20.0 if number >= 10 else 1.0) for number in range(LOOKS))
    assert missed(soaked(looks=growing(pss_mb=0.1))) == []
    assert missed(soaked(looks=warm)) == []


@pytest.mark.parametrize(
    ("changed", "names"),
    [
        ({"soaked_s": 40.0}, ["time soaked"]),
        ({"missing": 1}, ["robots without a process at the end"]),
        ({"violations": 1}, ["promises broken"]),
        ({"violations": None}, ["promises broken"]),
        (
            {"probes": (Probe(at_s=0.0, took_s=None), Probe(at_s=1.0, took_s=0.1))},
            ["probes refused", "admission, longest"],
        ),
        ({"probes": (Probe(at_s=0.0, took_s=1.5),)}, ["admission, longest"]),
    ],
)
def test_a_bound_that_was_passed_is_named(changed: dict[str, object], names: list[str]) -> None:
    assert missed(soaked(**changed)) == names


def test_a_fleet_that_never_formed_fails() -> None:
    assert not all_met(figures(soaked(soaked_s=0.0, looks=(), probes=(), missing=5, violations=None)))


def test_the_goal_is_further_away_than_the_leader_can_come() -> None:
    scenario = endless_queue(3, wall_s=600.0, speed=2.0)
    first, goal = scenario.fleet.start, scenario.goal
    assert first is not None
    assert goal is not None
    assert goal.at_m[0] - first[0] > scenario.drive.speed_mps * 2.0 * 600.0
    assert scenario.time.time_s_max > 2.0 * 600.0


def test_each_robot_is_killed_once_before_any_is_killed_again() -> None:
    order = list(itertools.islice(targets(5), 15))
    assert [sorted(order[at : at + 5]) for at in (0, 5, 10)] == [[1, 2, 3, 4, 5]] * 3
    assert order[:5] != order[5:10]
