"""Futures of a swarm's episode: the same plan up to an instant, and other faults from then on. Pure.

Rule 1: a future is named by its seed and its branches. Each branch is an instant and a number, and draws its
        faults from these alone. So a future is a plain plan that can be played from the start.
Rule 2: up to the instant of its last branch, a future is the same to the byte as the future without it. So
        a run may be forked there instead of being played again.
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

from clew.swarm.classes import ADVERSARY, INDEPENDENT, FaultClass, draw_rules
from clew.swarm.draws import Draws
from clew.swarm.strikes import strike
from clew.swarm.swarm import Mode, Swarm, draw
from clew.swarm.window import Window
from protocol.errors import UsageError
from protocol.faults.plan import Plan
from protocol.faults.rules import Drop, Kill, Partition, Rule, StepPoint
from protocol.keys import robot_name

HORIZON_S = 2.5  # the faults of a strike begin within 0.6 s, and the next view drives within 1.5 s of a death
KEEPS = 0.6  # share of futures in which the faults of before go on: most breaches need two faults at once
OPENS_S = (0.0, 1.0)  # faults of a future begin near its instant: that is what it was branched for
STRIKES = 0.8  # share of futures with a strike; the others have one or two classes of a swarm
CLASSES_MAX = 2
NEVER_S = 1e6  # longer than any run
AFTER_S = (
    0.001  # a branch lies just after the tick at which a run is forked: that tick has its messages behind it
)
DECIMALS = 3

_POOL = (*ADVERSARY, *ADVERSARY, *INDEPENDENT)
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
    from_s, purpose = branches[-1].from_s, f"future/{said(branches)}"
    draws = Draws(swarm.seed, purpose)
    rules = swarm.plan.rules
    kept = list(rules) if draws.chance(KEEPS) else clipped(rules, from_s, swarm.outside)
    window = Window(int(swarm.world["fleet"]["robots"]), None, OPENS_S)
    classes: list[FaultClass] = []
    if draws.chance(STRIKES):
        drawn = strike(Draws(swarm.seed, f"{purpose}/strike"), window, branches[-1].robot)
    else:
        classes = list(dict.fromkeys(draws.pick(_POOL) for _ in range(draws.whole(1, CLASSES_MAX))))
        drawn = [
            rule
            for each in classes
            for rule in draw_rules(each, Draws(swarm.seed, f"{purpose}/{each}"), window)
        ]
    named = [later(rule, from_s, f"{branches[-1]}-{place}") for place, rule in enumerate(drawn, start=1)]
    ends_s = round(from_s + HORIZON_S, DECIMALS)
    return dataclasses.replace(
        replaced(swarm, (*kept, *named), tuple(dict.fromkeys((*swarm.classes, *classes)))),
        mode=Mode.SAFETY,
        world=swarm.world | {"time": swarm.world["time"] | {"time_s_max": ends_s}},
        quiet_s=math.inf,
    )


def replaced(swarm: Swarm, rules: Sequence[Rule], classes: tuple[FaultClass, ...] = ()) -> Swarm:
    """The swarm with other rules, and with these classes if there are any."""
    plan = Plan(name=swarm.plan.name, description=swarm.plan.description, rules=tuple(rules))
    return dataclasses.replace(swarm, plan=plan, classes=classes or swarm.classes)


def clipped(rules: Sequence[Rule], from_s: float, outside: frozenset[int]) -> list[Rule]:
    """The rules without what they do from this time on. Permanent faults of robots outside stay."""
    kept: list[Rule] = []
    for rule in rules:
        if rule in IDLE or _is_permanent(rule, outside):
            kept.append(rule)
        elif rule.from_s < from_s:
            ends_s = from_s if rule.until_s is None else min(rule.until_s, from_s)
            kept.append(replace(rule, until_s=ends_s))
    return kept


def later(rule: Rule, by_s: float, name: str) -> Rule:
    """The rule, later by this time, under another name."""
    until_s = None if rule.until_s is None else round(rule.until_s + by_s, DECIMALS)
    return replace(
        rule,
        name=f"{rule.fault}-{name}".replace(":", "-"),
        from_s=round(rule.from_s + by_s, DECIMALS),
        until_s=until_s,
    )


def _is_permanent(rule: Rule, outside: frozenset[int]) -> bool:
    """Whether this may be the permanent fault of a robot outside; in liveness mode all others end."""
    if not outside or rule.until_s is not None:
        return False
    return isinstance(rule, Drop | Partition)
