"""A promise that no robot keeps, so that searches have something to find."""

from collections import Counter
from collections.abc import Iterator

import pytest

from protocol.keys import robot_number
from protocol.timeline import Entry, PromiseBroken, RobotStarted
from world.judge import judgement
from world.judge.rules.invariants import Counting
from world.judge.rules.rule import Dated


class _NeverAgain(Counting):
    """Counts, and allows no process of a robot but the first."""

    kinds = Counting.kinds | {RobotStarted}

    def __init__(self) -> None:
        super().__init__()
        self._starts: Counter[str] = Counter()

    def hear(self, source: str, entry: Entry) -> Iterator[Dated]:
        if not isinstance(entry.record, RobotStarted):
            yield from super().hear(source, entry)
            return
        self._starts[source] += 1
        if self._starts[source] > 1:
            robot = robot_number(source)
            assert robot is not None, "robots start"
            yield entry.t_s, PromiseBroken(invariant="P1", robot=robot, why="it is started again")


def break_at_restarts(monkeypatch: pytest.MonkeyPatch) -> None:
    """From now on a promise is broken once a robot has been started again."""
    monkeypatch.setattr(judgement, "Counting", _NeverAgain)
