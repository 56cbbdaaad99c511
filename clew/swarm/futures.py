"""Futures of a swarm's episode: the same plan up to an instant, and other faults from then on. Pure.

Rule 1: a future is named by its seed and its branches. Each branch is an instant and a number, and draws its
        faults from these alone. So a future is a plain plan that can be played from the start.
Rule 2: up to the instant of its last branch, a future is the same to the byte as the future without it. So
        a run may be forked there instead of being played again.
Rule 3: the plan of every future has rules that never strike (`IDLE`). A plan without any rule for points of a
        step, for scans or for partitions is followed along a shorter way, and rule 2 would not hold.
"""

import math
from collections.abc import Sequence

from msgspec import Struct
from msgspec.structs import replace

from clew.swarm.classes import ADVERSARY, FaultClass, draw_rules
from clew.swarm.draws import Draws
from clew.swarm.swarm import Mode, Swarm, draw, without_excess_kills
from clew.swarm.window import SOON_S, Window
from protocol.errors import UsageError
from protocol.faults.plan import Plan
from protocol.faults.rules import Drop, Kill, Partition, Rule, StepPoint
from protocol.keys import robot_name

KEEPS = 0.6  # share of futures in which the faults of before go on: most breaches need two faults at once
OPENS_S = (0.0, 2.0)  # faults of a future begin near its instant: that is what it was branched for
ROOM_S = 5.0  # the least time in which every class of faults can be drawn
ADVERSARY_SHARE = 0.5
CLASSES_MAX = 3
NEVER_S = 1e6  # longer than any run
AFTER_S = (
    0.001  # a branch lies just after the tick at which a run is forked: that tick has its messages behind it
)
DECIMALS = 3

IDLE: tuple[Rule, ...] = (
    Drop(name="idle-drop", from_s=NEVER_S),
    Partition(name="idle-partition", group=(robot_name(1),), from_s=NEVER_S),
    Kill(name="idle-point", target=robot_name(1), point=StepPoint.AFTER_PLAN, from_s=NEVER_S),
)
"""Rules that never strike."""


class Branch(Struct, frozen=True):
    """Where a future leaves the one before it, and which of the futures from there it is."""

    from_s: float
    future: int

    def __str__(self) -> str:
        return f"{self.from_s:.{DECIMALS}f}:{self.future}"


Branches = tuple[Branch, ...]


def said(branches: Branches) -> str:
    """The branches as a text, such as `3.101:2,7.401:1`."""
    return ",".join(map(str, branches))


def read_branches(text: str) -> Branches:
    """The branches in a text.

    Raises:
        UsageError: the text is none that `said` makes.
    """
    try:
        parts = [part.split(":") for part in text.split(",") if part]
        branches = tuple(Branch(float(from_s), int(future)) for from_s, future in parts)
    except ValueError:
        branches = ()
    if said(branches) != text or any(not each.from_s < NEVER_S for each in branches):
        raise UsageError(f"--future: must be like 3.101:2,7.401:1, got {text!r}")
    return branches


def branch_at(now_s: float, future: int) -> Branch:
    """A branch just after the tick at this time."""
    return Branch(round(now_s + AFTER_S, DECIMALS), future)


def branches_until_s(swarm: Swarm) -> float:
    """Until when the swarm has futures: new faults need time before the time at which all are over."""
    return math.inf if swarm.mode is Mode.SAFETY else swarm.quiet_s - SOON_S - ROOM_S


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
    robots = int(swarm.world["fleet"]["robots"])
    until_s = None if swarm.mode is Mode.SAFETY else round(swarm.quiet_s - SOON_S - from_s, DECIMALS)
    window = Window(robots, until_s, OPENS_S)
    classes = _classes(draws)
    drawn = [
        rule for each in classes for rule in draw_rules(each, Draws(swarm.seed, f"{purpose}/{each}"), window)
    ]
    if swarm.mode is Mode.LIVENESS:
        killed = sum(rule.robots for rule in kept if isinstance(rule, Kill) and rule not in IDLE)
        drawn = without_excess_kills(drawn, kills_max=robots - (3 if swarm.outside else 1) - killed)
    named = [later(rule, from_s, f"{branches[-1]}-{place}") for place, rule in enumerate(drawn, start=1)]
    return replaced(swarm, (*kept, *named), tuple(dict.fromkeys((*swarm.classes, *classes))))


def replaced(swarm: Swarm, rules: Sequence[Rule], classes: tuple[FaultClass, ...] = ()) -> Swarm:
    """The swarm with other rules, and with these classes if there are any."""
    said = {name: getattr(swarm, name) for name in Swarm.__dataclass_fields__}
    plan = Plan(name=swarm.plan.name, description=swarm.plan.description, rules=tuple(rules))
    return Swarm(**(said | {"plan": plan, "classes": classes or swarm.classes}))


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


def _classes(draws: Draws) -> list[FaultClass]:
    """One to three classes: breaches need few faults, but these within seconds."""
    pools = [ADVERSARY if draws.chance(ADVERSARY_SHARE) else tuple(FaultClass) for _ in range(CLASSES_MAX)]
    picked = [draws.pick(pool) for pool in pools[: draws.whole(1, CLASSES_MAX)]]
    return list(dict.fromkeys(picked))
