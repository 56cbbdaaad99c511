"""Names of processes, as they stand in keys and in logs."""

import pytest

from protocol.keys import robot_number


@pytest.mark.parametrize(
    ("name", "robot"), [("r1", 1), ("r2000", 2000), ("world", None), ("r", None), ("r-1", None)]
)
def test_a_robot_has_its_number_in_its_name(name: str, robot: int | None) -> None:
    assert robot_number(name) == robot


def test_a_name_of_thousands_of_digits_is_no_robot() -> None:
    assert robot_number("r" + "9" * 5000) is None
