"""A law of a user that does not return is recorded by its robot's process, while it goes on."""

import signal
from collections.abc import Callable, Iterator

import pytest

from agents.navigation.law import Seen
from agents.navigation.step import Step
from agents.process.endless_law import ALARM_S, watch_law
from protocol import laws
from protocol.frames import Point
from protocol.timeline import LawStalled, Record
from tests.support.stages.one_step import Driven, step_through, under, wall

AHEAD = [wall((1.0, -1.0), (1.0, 1.0))]


@pytest.fixture
def alarms() -> Iterator[Callable[[], None]]:
    """Lets an alarm come at once; none comes by itself."""
    before = signal.getsignal(signal.SIGALRM)
    yield lambda: signal.raise_signal(signal.SIGALRM)
    signal.setitimer(signal.ITIMER_REAL, 0.0)
    signal.signal(signal.SIGALRM, before)


def asked(law: Callable[[Seen], Step], name: str = "mine") -> Driven | object:
    """A leader asks this law once."""
    if name not in laws.OURS:
        laws.register(name, law)
    mission = under(name, robot_radius_m=0.1, goal=Point(x_m=3.0, y_m=0.0), goal_tolerance_m=0.1)
    return step_through(AHEAD, mission)


@pytest.fixture(autouse=True)
def no_laws(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(laws, "_registered", {})


def test_a_call_that_two_alarms_find_is_recorded_once_with_its_line(alarms: Callable[[], None]) -> None:
    recorded: list[Record] = []

    def slow(_: Seen) -> Step:
        for _alarm in range(4):
            alarms()
            so_far.append(len(recorded))
        return Step(0.0, 0.5)

    so_far: list[int] = []
    watch_law("mine", recorded.append)
    assert isinstance(asked(slow), Driven), "it has returned, and its step counts"
    assert so_far == [0, 1, 1, 1]
    [stalled] = recorded
    assert isinstance(stalled, LawStalled)
    assert (stalled.law, stalled.after_s) == ("mine", ALARM_S)
    assert stalled.at.startswith("test_endless_law.py:")


def test_calls_that_return_between_alarms_are_not_recorded(alarms: Callable[[], None]) -> None:
    recorded: list[Record] = []

    def quick(_: Seen) -> Step:
        alarms()
        return Step(0.0, 0.5)

    watch_law("mine", recorded.append)
    for _ in range(3):
        asked(quick)
    alarms()
    alarms()
    assert recorded == []


@pytest.mark.usefixtures("alarms")
def test_there_is_no_alarm_for_a_law_of_ours() -> None:
    recorded: list[Record] = []
    watch_law("certified", recorded.append)
    assert signal.getitimer(signal.ITIMER_REAL) == (0.0, 0.0)
    watch_law("mine", recorded.append)
    assert signal.getitimer(signal.ITIMER_REAL)[1] == ALARM_S
