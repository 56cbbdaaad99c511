"""Names of processes in keys and in logs."""

import pytest

from protocol.keys import matches, robot_number


@pytest.mark.parametrize(
    ("name", "robot"), [("r1", 1), ("r2000", 2000), ("world", None), ("r", None), ("r-1", None)]
)
def test_the_name_of_a_robot_contains_its_number(name: str, robot: int | None) -> None:
    assert robot_number(name) == robot


def test_a_name_with_thousands_of_digits_is_not_a_robots() -> None:
    assert robot_number("r" + "9" * 5000) is None


@pytest.mark.parametrize(
    ("pattern", "meant"),
    [("a/*/c", True), ("a/b/*", True), ("a/b", False), ("a/x/*", False), ("*/*/*/*", False)],
)
def test_a_star_stands_for_one_chunk(pattern: str, meant: bool) -> None:
    assert matches(pattern, "a/b/c") is meant
