"""The faults of a plan when the world is killed: each part strikes once, in one of its lives."""

import pytest

from protocol.faults.plan import Plan
from protocol.faults.rules import Freeze, Kill, Restart, Rule, Slow
from protocol.timeline import Entry, FaultInjected, Record, WorldResumed
from tests.support.strands import formed
from world.faults import RunFaults

TICK_S = 0.1
AWAY_S = 1.0
RULES: tuple[Rule, ...] = (
    Restart(target="r2", from_s=1.0, after_s=0.5),
    Freeze(target="r3", from_s=2.0, for_s=0.5),
    Slow(target="r1", from_s=3.0, delay_s=0.2, for_s=2.0),
    Slow(target="r4", from_s=3.0, delay_s=0.1),
    Restart(target="leader", robots=2, from_s=1.0, after_s=1.5),
    Restart(target="world", from_s=1.2, after_s=9.0),
    Kill(target="r2", from_s=6.0),
)
ONCE = [
    *(("kill", "r2"), ("kill", "r5"), ("kill", "r6"), ("kill", "world"), ("start", "r2")),
    *(("freeze", "r3"), ("start", "r5"), ("start", "r6"), ("start", "world"), ("thaw", "r3")),
    *(("slow", "r1"), ("slow", "r4"), ("unslow", "r1"), ("kill", "r2")),
]
Lines = list[tuple[str, Entry]]


def plan() -> Plan:
    return Plan(name="test", rules=RULES)


def begun() -> "Life":
    """The first life, when r5 leads a strand and r6 is behind it."""
    return Life([("r5", Entry(n=1, t_s=0.0, hlc="", record=formed(10_005, 5, 6, 1, 2, 3, 4)))])


class Life:
    """The faults of one life of a world, and the timeline of all lives."""

    def __init__(self, lines: Lines) -> None:
        self.faults, self.lines = RunFaults(plan(), 1, robots=6), lines
        for source, entry in lines:
            self.faults.recall(source, "", entry)

    def write(self, record: Record, t_s: float) -> None:
        entry = Entry(n=len(self.lines) + 1, t_s=t_s, hlc="", record=record)
        self.lines.append(("world", entry))
        self.faults.hear("world", entry)

    def live(self, from_tick: int, to_tick: int) -> None:
        for tick in range(from_tick, to_tick):
            for fault in self.faults.due(tick * TICK_S):
                self.write(fault.as_record(), tick * TICK_S)

    def resumed(self, at_tick: int) -> "Life":
        again = Life(self.lines)
        again.write(WorldResumed(life=1, entries=len(self.lines), torn_bytes=0), at_tick * TICK_S)
        return again


def injected(lines: Lines) -> list[tuple[str, str]]:
    records = [entry.record for _, entry in lines]
    return [(each.fault, str(each.process)) for each in records if isinstance(each, FaultInjected)]


def slow_s(faults: RunFaults) -> list[float]:
    return [faults.of(robot).slow_s for robot in ("r1", "r2", "r3", "r4")]


@pytest.mark.parametrize("killed_at", range(0, 80, 3))
def test_each_part_of_a_fault_is_injected_once_whenever_the_world_is_killed(killed_at: int) -> None:
    first = begun()
    first.live(0, killed_at)
    before = slow_s(first.faults)
    second = first.resumed(killed_at + 10)
    assert slow_s(second.faults) == before, "a robot that is slow stays slow"
    second.live(killed_at + 10, killed_at + 25)
    third = second.resumed(killed_at + 35)
    third.live(killed_at + 35, killed_at + 200)
    assert sorted(injected(third.lines)) == sorted(ONCE)


def test_a_robot_that_was_started_again_before_the_world_was_killed_can_be_killed_for_good() -> None:
    first = begun()
    first.live(0, 20)
    assert ("start", "r2") in injected(first.lines)
    second = first.resumed(30)
    second.live(30, 100)
    of_r2 = [fault for fault, process in injected(second.lines) if process == "r2"]
    assert of_r2 == ["kill", "start", "kill"]
