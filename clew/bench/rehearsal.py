"""How fast rehearsals are, under fault plans and with many robots: simulated seconds per CPU second.

Rule 1: each is compared with its lower limit: the same ticks and messages in the same heap, with cores that
        do nothing. Where it is installed, ir-sim is a further baseline for a rehearsal without faults
        (`clew.bench.peer`).
Rule 2: all repeats are the same run. CPU time counts, which other load on the machine changes least.
Rule 3: queues of different lengths drive the same way over open ground. What a robot costs in a simulated
        second is compared with what it costs in the shortest queue.
"""

from collections.abc import Callable, Sequence
from functools import partial

from msgspec import Struct

from clew.bench.result import Aim, Figure, figure
from clew.rehearsal.network import Network
from clew.rehearsal.rehearsal import Rehearsal
from protocol.faults.plan import Plan
from world.bodies.arena import TICK_S
from world.scenario.scenario import Scenario

Clock = Callable[[], float]
Peer = Callable[[Scenario], Callable[[float], None]]
"""Makes a world of this scene; returns what simulates so many seconds of it."""

PEER = "ir-sim, steps alone"
SEED = 1
REAL_TIMES_AIM, FAULTY_REAL_TIMES_AIM = 300.0, 200.0
FEW_ROBOTS = 5  # of which the aims tell
GROWTH_AIM = 1.3  # of the cost of a robot, from the shortest queue to any other


class Speed(Struct, frozen=True, kw_only=True):
    """How fast a rehearsal is."""

    name: str
    """Of its figures."""
    robots: int
    faults: int
    """The number of rules in the fault plan."""
    sim_s: float
    messages: int
    """Messages sent, without queries and their answers."""
    cpu_s: tuple[float, ...]
    """Of each repeat."""
    bare_s: tuple[float, ...]
    """Of ticks and messages alone, right after each repeat."""
    peer_s: tuple[float, ...] = ()
    """Of the peer, for as many simulated seconds, right after that; empty: it was not asked."""

    @property
    def robot_ms(self) -> list[float]:
        """CPU milliseconds of each repeat for one robot in one simulated second."""
        return [1000.0 * each / (self.robots * self.sim_s) for each in self.cpu_s]


def speed(
    name: str, scenario: Scenario, plan: Plan, *, runs: int, cpu: Clock, peer: Peer | None = None
) -> Speed:
    """Time a rehearsal and its baselines, some times."""
    rehearsal = Rehearsal(scenario, SEED, plan).run()  # warms up the caches, and is not timed
    settled = rehearsal.world.tally.settled.values()
    sent = [rehearsal.account.sent, *(robot.sent for robot in settled)]
    messages, sim_s = sum(sum(each.values()) for each in sent), rehearsal.world.now_s
    cpu_s: list[float] = []
    bare_s: list[float] = []
    peer_s: list[float] = []
    for _ in range(runs):
        cpu_s.append(_timed_s(lambda: Rehearsal(scenario, SEED, plan).run(), cpu))
        bare_s.append(_timed_s(lambda: _dispatch(messages, round(sim_s / TICK_S)), cpu))
        if peer is not None:
            peer_s.append(_timed_s(partial(peer(scenario), sim_s), cpu))
    return Speed(
        name=name,
        robots=scenario.fleet.robots,
        faults=len(plan.rules),
        sim_s=sim_s,
        messages=messages,
        cpu_s=tuple(cpu_s),
        bare_s=tuple(bare_s),
        peer_s=tuple(peer_s),
    )


def figures_of(speed: Speed) -> list[Figure]:
    """Simulated seconds, and messages, per CPU second."""
    least = FAULTY_REAL_TIMES_AIM if speed.faults else REAL_TIMES_AIM
    beside = {"ticks and messages alone": speed.bare_s, PEER: speed.peer_s}
    return [
        figure(
            speed.name,
            "simulated s per CPU s",
            [speed.sim_s / each for each in speed.cpu_s],
            baselines={
                name: [speed.sim_s / each for each in took_s] for name, took_s in beside.items() if took_s
            },
            aim=Aim(at_least=least) if speed.robots == FEW_ROBOTS else None,
        ),
        figure(speed.name, "messages per CPU s", [speed.messages / each for each in speed.cpu_s]),
    ]


def growth(queues: Sequence[Speed]) -> list[Figure]:
    """Rule 3, for queues that were timed equally often; the shortest comes first."""
    if not queues:
        return []
    shortest, *longer = sorted(queues, key=lambda queue: queue.robots)
    unit = "CPU ms per robot and simulated s"
    return [figure(shortest.name, unit, shortest.robot_ms)] + [
        figure(
            queue.name,
            unit,
            queue.robot_ms,
            baselines={shortest.name: shortest.robot_ms},
            aim=Aim(of=shortest.name, at_most=GROWTH_AIM),
        )
        for queue in longer
    ]


def _timed_s(run: Callable[[], object], cpu: Clock) -> float:
    since_s = cpu()
    run()
    return cpu() - since_s


def _dispatch(messages: int, ticks: int) -> None:
    """Rule 1, with messages spread evenly over the ticks, each due when it is sent."""
    network = Network[int]()
    for tick in range(ticks):
        now_s = tick * TICK_S
        for number in range(messages * tick // ticks, messages * (tick + 1) // ticks):
            network.send(number, now_s)
        while network.next_due(now_s) is not None:
            pass
