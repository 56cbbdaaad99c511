"""How the books of a run are closed: its verdict, from what the world of it knows. Live or rehearsed."""

from collections.abc import Mapping
from dataclasses import dataclass

from protocol.faults.plan import Plan
from protocol.keys import WORLD, robot_name
from world.core import World
from world.judge.books import Account, balance
from world.judge.tally import Tally
from world.judge.verdict import Events, Facts, Verdict, pass_verdict


@dataclass(frozen=True, slots=True, kw_only=True)
class Circumstances:
    """What a world does not know of its own run."""

    seed: int
    speed: float | None
    started_at: str
    plan: Plan
    """What was to go wrong."""
    traffic: Account | None
    """The world's own; None: it went on from its timeline, and its counts of before went with its process."""
    recorded: int
    missing: Mapping[str, int]
    """Entries that each source is known to have made and that are not recorded."""
    wall_s: float
    cpu_s: float


def verdict_of(world: World, circumstances: Circumstances) -> Verdict:
    """The verdict on a run that the world has judged."""
    assert world.judgement is not None, "a verdict needs a judgement"
    assert world.ending is not None, "a verdict needs an ending"
    tally, attendance = world.tally, world.attendance
    # What a dead robot had not told, it took with it; of the living, the last entry says that it is the last.
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
            messages=balance(accounts, robots=sorted(attendance.robots), taken=tally.taken),
            events=Events(
                recorded=circumstances.recorded,
                missing=missing + len(untold) + tally.unrecorded_count,
            ),
            unstruck=tuple(name for name in circumstances.plan.names if name not in tally.struck),
            sim_s=world.over_s,
            wall_s=circumstances.wall_s,
            cpu_s=circumstances.cpu_s,
        )
    )


def _accounts(tally: Tally) -> dict[str, Account]:
    """Of each robot that told both its counts, and of all its life: not of one that was started again."""
    return {
        robot_name(robot): Account(
            sent=tally.settled[robot].sent,
            received=counted.received,
            newest=counted.newest,
            injected=counted.injected,
            refused=counted.refused,
        )
        for robot, counted in tally.counted.items()
        if robot in tally.settled and robot not in tally.restarted
    }
