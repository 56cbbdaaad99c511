"""How parts are started: the robots of a large fleet give way to its world."""

import pytest

from clew.fleet.parts.command_lines import NICE_MAX, NICE_STEP, ROBOTS_WEIGH, nice_of


@pytest.mark.parametrize(
    ("robots", "cores", "nice"),
    [(1, 2, 0), (5, 2, 0), (8, 2, 0), (9, 2, 1), (50, 2, 9), (200, 2, 15), (1000, 2, 19), (1000, 64, 7)],
)
def test_robots_give_way_where_many_share_a_core(robots: int, cores: int, nice: int) -> None:
    assert nice_of(robots, cores) == nice


@pytest.mark.parametrize("robots", range(1, 400, 7))
def test_the_robots_of_a_core_weigh_no_more_together_than_the_world_can_stand(robots: int) -> None:
    nice = nice_of(robots, 1)
    assert robots / NICE_STEP**nice <= ROBOTS_WEIGH or nice == NICE_MAX
