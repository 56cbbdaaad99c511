"""The clocks of several fleets: they tick together or not at all."""

from dataclasses import dataclass
from typing import cast

import pytest

from world.life import Life
from world.pace import GLANCE_S
from world.shell import _wait_s


@dataclass(eq=False)
class Clock:
    """What the shell asks a life about its clock."""

    due_s: float = 0.0
    is_over: bool = False
    has_started: bool = True

    def wait_s(self, _: float) -> float:
        return self.due_s


LATE, DUE, OVER, UNBORN = Clock(0.04), Clock(0.0), Clock(0.08, is_over=True), Clock(has_started=False)


@pytest.mark.parametrize(
    ("clocks", "wait_s"),
    [
        ([DUE, DUE], 0.0),
        ([DUE, LATE], 0.04),  # nobody is left behind
        ([DUE, OVER], 0.0),  # a run that is over holds up nobody
        ([OVER, OVER], 0.08),
        ([DUE, UNBORN], GLANCE_S),  # no fleet drives before the robots of all have come
    ],
)
def test_clocks_tick_once_those_of_all_whose_runs_go_on_are_due(clocks: list[Clock], wait_s: float) -> None:
    assert _wait_s([cast("Life", each) for each in clocks], 0.0) == wait_s
