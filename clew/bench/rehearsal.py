"""How fast rehearsals are under fault plans: simulated seconds per wall-clock second.

Rule 1: each is compared with its lower limit: the same ticks and messages in the same heap, with cores that
        do nothing.
Rule 2: all repeats are the same run, and differ only by the machine's other load.
"""

from collections.abc import Callable

from msgspec import Struct

from clew.bench.result import Figure, figure
from clew.rehearsal.network import Network
from clew.rehearsal.rehearsal import Rehearsal
from protocol.faults.plan import Plan
from world.bodies.arena import TICK_S
from world.scenario.scenario import Scenario

Clock = Callable[[], float]

SEED = 1


class Speed(Struct, frozen=True, kw_only=True):
    """How fast a rehearsal is."""

    faults: str
    """The fault plan's name."""
    sim_s: float
    messages: int
    """Messages sent, without queries and their answers."""
    wall_s: tuple[float, ...]
    """Of each repeat."""
    bare_s: tuple[float, ...]
    """Of ticks and messages alone, right after each repeat."""


def speed(scenario: Scenario, plan: Plan, *, runs: int, wall: Clock) -> Speed:
    """Time a rehearsal and its lower limit, some times."""
    rehearsal = Rehearsal(scenario, SEED, plan).run()  # warms up the caches, and is not timed
    settled = rehearsal.world.tally.settled.values()
    sent = [rehearsal.account.sent, *(robot.sent for robot in settled)]
    messages, sim_s = sum(sum(each.values()) for each in sent), rehearsal.world.now_s
    wall_s: list[float] = []
    bare_s: list[float] = []
    for _ in range(runs):
        wall_s.append(_timed_s(lambda: Rehearsal(scenario, SEED, plan).run(), wall))
        bare_s.append(_timed_s(lambda: _dispatch(messages, round(sim_s / TICK_S)), wall))
    return Speed(faults=plan.name, sim_s=sim_s, messages=messages, wall_s=tuple(wall_s), bare_s=tuple(bare_s))


def figure_of(speed: Speed) -> Figure:
    """Simulated seconds per wall-clock second."""
    bare = [speed.sim_s / each for each in speed.bare_s]
    return figure(
        f"faults: {speed.faults}",
        "times real time",
        [speed.sim_s / each for each in speed.wall_s],
        baselines={"ticks and messages alone": bare},
    )


def _timed_s(run: Callable[[], object], wall: Clock) -> float:
    since_s = wall()
    run()
    return wall() - since_s


def _dispatch(messages: int, ticks: int) -> None:
    """Rule 1, with messages spread evenly over the ticks, each due when it is sent."""
    network = Network[int]()
    for tick in range(ticks):
        now_s = tick * TICK_S
        for number in range(messages * tick // ticks, messages * (tick + 1) // ticks):
            network.send(number, now_s)
        while network.next_due(now_s) is not None:
            pass
