"""How fast rehearsals are under fault plans: simulated seconds per wall-clock second.

Rule 1: each is compared with its lower limit: the same ticks and messages in the same heap, with cores that
        do nothing.
Rule 2: all runs of one row are the same run and differ only by the machine's other load; the median counts.
"""

from collections.abc import Callable

from msgspec import Struct

from clew.percentiles import percentile
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
    wall_s: float
    real_times: float
    """Simulated seconds per wall-clock second."""
    bare_real_times: float
    """The same for ticks and messages alone."""


def speed(scenario: Scenario, plan: Plan, *, runs: int, wall: Clock) -> Speed:
    """Time a rehearsal, and its lower limit, in the median of some runs."""
    rehearsal = Rehearsal(scenario, SEED, plan).run()  # warms up the caches, and is not timed
    settled = rehearsal.world.tally.settled.values()
    sent = [rehearsal.account.sent, *(robot.sent for robot in settled)]
    messages, sim_s = sum(sum(each.values()) for each in sent), rehearsal.world.now_s
    wall_s = _median_s(lambda: Rehearsal(scenario, SEED, plan).run(), runs, wall)
    bare_s = _median_s(lambda: _dispatch(messages, round(sim_s / TICK_S)), runs, wall)
    return Speed(
        faults=plan.name,
        sim_s=sim_s,
        messages=messages,
        wall_s=wall_s,
        real_times=sim_s / wall_s,
        bare_real_times=sim_s / bare_s,
    )


def _median_s(run: Callable[[], object], runs: int, wall: Clock) -> float:
    times_s: list[float] = []
    for _ in range(runs):
        since_s = wall()
        run()
        times_s.append(wall() - since_s)
    return percentile(times_s, 50)


def _dispatch(messages: int, ticks: int) -> None:
    """Rule 1, with messages spread evenly over the ticks, each due when it is sent."""
    network = Network[int]()
    for tick in range(ticks):
        now_s = tick * TICK_S
        for number in range(messages * tick // ticks, messages * (tick + 1) // ticks):
            network.send(number, now_s)
        while network.next_due(now_s) is not None:
            pass
