"""Spread, baseline, aim: what all benchmarks share."""

import math

import pytest

from clew.bench.result import Aim, figure, spread


def test_a_spread_has_the_least_the_quartiles_and_the_most() -> None:
    found = spread([5.0, 1.0, 2.0, 4.0, 3.0])
    assert (found.repeats, found.least, found.quartile, found.median) == (5, 1.0, 2.0, 3.0)
    assert (found.quartile_3, found.most) == (4.0, 5.0)


def test_what_never_came_is_none() -> None:
    found = spread([1.0, math.inf, math.inf])
    assert (found.least, found.median, found.most) == (1.0, None, None)


def test_the_ratio_is_taken_repeat_by_repeat() -> None:
    # The machine was three times as slow in the first repeat, for both.
    (base,) = figure("it", "s", [6.0, 2.0, 2.0], baselines={"other": [3.0, 1.0, 1.0]}).baselines
    assert (base.ratio.least, base.ratio.most) == (2.0, 2.0)


def test_what_never_came_is_infinitely_longer_than_its_baseline() -> None:
    (base,) = figure("it", "s", [math.inf, 1.0], baselines={"other": [math.inf, 2.0]}).baselines
    assert (base.ratio.least, base.ratio.most) == (0.5, None)


@pytest.mark.parametrize(
    ("aim", "met"),
    [
        (Aim(at_most=2.0), True),
        (Aim(at_most=1.9), False),
        (Aim(at_least=2.0), True),
        (Aim(at_least=2.1), False),
        (Aim(of="other", at_most=0.5), True),
        (Aim(of="other", at_most=0.4), False),
        (None, None),
    ],
)
def test_an_aim_is_of_the_figure_or_of_the_ratio_to_a_baseline(aim: Aim | None, met: bool | None) -> None:
    assert figure("it", "s", [2.0], baselines={"other": [4.0]}, aim=aim).met is met


@pytest.mark.parametrize(
    ("aim", "met"),
    [
        (Aim(at_most=2.0), True),
        (Aim(at_most=2.0, each=True), False),
        (Aim(at_most=3.0, each=True), True),
        (Aim(at_least=2.0, each=True), False),
    ],
)
def test_an_aim_is_of_the_median_or_of_each_repeat(aim: Aim, met: bool) -> None:
    assert figure("it", "s", [1.0, 2.0, 3.0], aim=aim).met is met


def test_an_aim_without_bounds_is_to_come_at_all() -> None:
    assert [figure("it", "s", [1.0, more], aim=Aim(each=True)).met for more in (9.0, math.inf)] == [
        True,
        False,
    ]


def test_what_never_came_reaches_no_aim() -> None:
    assert figure("it", "s", [math.inf], aim=Aim(at_least=1.0)).met is False
