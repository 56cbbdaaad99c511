"""Makes the verdict of a run from the state of its world, live or rehearsed."""

from collections.abc import Mapping
from dataclasses import dataclass

from msgspec.structs import replace

from protocol.faults.plan import Plan
from protocol.keys import WORLD, robot_name
from protocol.timeline import TrafficCounted
from world.core import World
from world.judge.books import balance
from world.judge.tally import Tally
from world.judge.verdict import Events, Facts, Late, Verdict, pass_verdict


@dataclass(frozen=True, slots=True, kw_only=True)
class Circumstances:
    """Facts about a run that its world does not know."""

    seed: int
    speed: float | None
    started_at: str
    plan: Plan
    """The fault plan."""
    traffic: TrafficCounted | None
    """The world's own counts; None: the world was resumed, and the counts of its first process are lost."""
    recorded: int
    """Entries that stand in the timeline."""
    missing: Mapping[str, int]
    """By source: the number of entries that are known to exist and are not recorded."""
    lost: int = 0
    """Entries that were recorded and do not stand in the timeline."""
    wall_s: float
    cpu_s: float
    speed_reached: float | None = None
    """Simulated seconds per wall-clock second of the world's clock; None: in lock-step or rehearsed."""
    ticks_late: Late | None = None


def verdict_of(world: World, circumstances: Circumstances) -> Verdict:
    """The verdict on a run that the world has judged."""
    assert world.judgement is not None, "a verdict needs a judgement"
    assert world.ending is not None, "a verdict needs an ending"
    tally, attendance = world.tally, world.attendance
    # Missing entries of dead robots are lost with them. A living robot's last entry says that it is the last.
    untold = attendance.living - tally.counted.keys()
    missing = sum(circumstances.missing.get(robot_name(robot), 0) for robot in attendance.living)
    accounts = _accounts(tally)
    if circumstances.traffic is not None:
        accounts[WORLD] = circumstances.traffic
    return pass_verdict(
        Facts(
            scenario=world.scenario,
            seed=circumstances.seed,
            speed=circumstances.speed,
            started_at=circumstances.started_at,
            ending=world.ending,
            absent=", ".join(map(robot_name, attendance.missing)),
            living=world.survivors,
            tally=tally,
            judgement=world.judgement,
            messages=balance(accounts, removed=tally.removed),
            events=Events(
                recorded=circumstances.recorded,
                missing=missing + len(untold) + tally.unrecorded_count,
                lost=circumstances.lost,
            ),
            unstruck=tuple(name for name in circumstances.plan.names if name not in tally.struck),
            sim_s=world.over_s,
            wall_s=circumstances.wall_s,
            cpu_s=circumstances.cpu_s,
            speed_reached=circumstances.speed_reached,
            ticks_late=circumstances.ticks_late,
        )
    )


def _accounts(tally: Tally) -> dict[str, TrafficCounted]:
    """The accounts of robots that recorded both counts for the whole run; restarted robots have none."""
    return {
        robot_name(robot): replace(counted, sent=tally.settled[robot].sent)
        for robot, counted in tally.counted.items()
        if robot in tally.settled and robot not in tally.restarted
    }
