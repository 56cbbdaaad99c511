"""Futures of a swarm's episode: the same plan, and a strike at an instant. Pure.

Rule 1: a future is named by its seed and its branches. Each branch is an instant, a robot and a number, and
        draws its strike from these alone; the faults of before go on. So a future is a plain plan that can
        be played from the start.
Rule 2: up to the instant of its last branch, a future is the same to the byte as the future without it. So
        a run may turn into it there (`chain`) instead of being played again.
Rule 3: a future ends `HORIZON_S` after its last branch, and is checked for safety: its world has that time
        limit, and its mode is `safety`. So it ends there however it is played.
Rule 4: the plan of every future has rules that never strike (`IDLE`). A plan without any rule for points of a
        step, for scans or for partitions is followed along a shorter way, and rule 2 would not hold.
"""

import dataclasses
import math
from collections.abc import Sequence

from msgspec import Struct
from msgspec.structs import replace

from clew.swarm.draws import Draws
from clew.swarm.strikes import strike
from clew.swarm.swarm import Mode, Swarm, draw
from clew.swarm.window import Window
from protocol.errors import UsageError
from protocol.faults.plan import Plan
from protocol.faults.rules import Drop, Kill, Partition, Rule, StepPoint
from protocol.keys import robot_name

HORIZON_S = 2.0  # a strike begins within 0.8 s, and nine of ten breaches come within 1.9 s
NEVER_S = 1e6  # longer than any run
AFTER_S = (
    0.001  # a branch lies just after the tick at which a run turns: that tick has its messages behind it
)
DECIMALS = 3

IDLE: tuple[Rule, ...] = (
    Drop(name="idle-drop", from_s=NEVER_S),
    Partition(name="idle-partition", group=(robot_name(1),), from_s=NEVER_S),
    Kill(name="idle-point", target=robot_name(1), point=StepPoint.AFTER_PLAN, from_s=NEVER_S),
)
"""Rules that never strike."""


class Branch(Struct, frozen=True):
    """Where a future leaves the one before it, which robot its faults are about, and which future it is."""

    from_s: float
    robot: int
    future: int

    def __str__(self) -> str:
        return f"{self.from_s:.{DECIMALS}f}:{robot_name(self.robot)}:{self.future}"


Branches = tuple[Branch, ...]


def said(branches: Branches) -> str:
    """The branches as a text, such as `3.101:r4:2,7.401:r1:1`."""
    return ",".join(map(str, branches))


def read_branches(text: str) -> Branches:
    """The branches in a text.

    Raises:
        UsageError: the text is none that `said` makes.
    """
    try:
        parts = [part.split(":") for part in text.split(",") if part]
        branches = tuple(
            Branch(float(from_s), int(robot.removeprefix("r")), int(future))
            for from_s, robot, future in parts
        )
    except ValueError:
        branches = ()
    if said(branches) != text or any(not each.from_s < NEVER_S for each in branches):
        raise UsageError(f"--future: must be like 3.101:r4:2,7.401:r1:1, got {text!r}")
    return branches


def branch_at(now_s: float, robot: int, future: int) -> Branch:
    """A branch just after the tick at this time."""
    return Branch(round(now_s + AFTER_S, DECIMALS), robot, future)


def draw_future(seed: int, branches: Branches) -> Swarm:
    """The swarm of a future; without branches, the seed's own with the rules of `IDLE`."""
    swarm = draw(seed)
    swarm = replaced(swarm, (*swarm.plan.rules, *IDLE))
    for depth in range(len(branches)):
        swarm = branched(swarm, branches[: depth + 1])
    return swarm


def branched(swarm: Swarm, branches: Branches) -> Swarm:
    """The future of a swarm that has all of these branches but the last."""
    from_s = branches[-1].from_s
    window = Window(int(swarm.world["fleet"]["robots"]), None)
    drawn = strike(Draws(swarm.seed, f"future/{said(branches)}"), window, branches[-1].robot)
    named = [later(rule, from_s, f"{branches[-1]}-{place}") for place, rule in enumerate(drawn, start=1)]
    ends_s = round(from_s + HORIZON_S, DECIMALS)
    return dataclasses.replace(
        replaced(swarm, (*swarm.plan.rules, *named)),
        mode=Mode.SAFETY,
        world=swarm.world | {"time": swarm.world["time"] | {"time_s_max": ends_s}},
        quiet_s=math.inf,
    )


def replaced(swarm: Swarm, rules: Sequence[Rule]) -> Swarm:
    """The swarm with other rules."""
    plan = Plan(name=swarm.plan.name, description=swarm.plan.description, rules=tuple(rules))
    return dataclasses.replace(swarm, plan=plan)


def later(rule: Rule, by_s: float, name: str) -> Rule:
    """The rule, later by this time, under another name."""
    until_s = None if rule.until_s is None else round(rule.until_s + by_s, DECIMALS)
    return replace(
        rule,
        name=f"{rule.fault}-{name}".replace(":", "-"),
        from_s=round(rule.from_s + by_s, DECIMALS),
        until_s=until_s,
    )
