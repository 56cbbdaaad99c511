"""The classes of faults that a swarm mixes, and how the rules of each are drawn. Pure.

Rule 1: each class draws from a stream of its own, so that a class more or less moves no other.
Rule 2: in a window that closes, all that a class does is over when it closes; a robot killed stays so.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from enum import StrEnum
from typing import TypedDict

from lab.dice import Dice
from protocol.faults.rules import (
    ROUTER,
    Burst,
    Corrupt,
    Delay,
    Drop,
    Duplicate,
    Freeze,
    Kill,
    MessageKind,
    Partition,
    Reorder,
    Restart,
    Rule,
    Slow,
    StepPoint,
)
from protocol.keys import WORLD, robot_name

Kinds = tuple[MessageKind, ...]

ALL_KINDS: Kinds = ()
LINKS: Kinds = ("ahead", "behind")
MUSTER: Kinds = ("muster", "beacon", "plea")
BODY: Kinds = ("drive", "odometry")
ORDERS: Kinds = ("drive",)
ODOMETRY: Kinds = ("odometry",)
SCANS: Kinds = ("scan", "scan_query")
SOON_S = 0.5  # five odometries: whoever is to be struck is there by then, or is spared
BEGINS_S = (0.5, 16.0)  # fleets are under way by then, and most are not yet there


class FaultClass(StrEnum):
    """What can be in the mix."""

    LOSS = "loss"
    DELAY = "delay"
    DUPLICATION = "duplication"
    REORDERING = "reordering"
    CORRUPTION = "corruption"
    BURSTS = "bursts"
    BODY_LINK = "body_link"
    CUT_PAIR = "cut_pair"
    CUT_ROBOT = "cut_robot"
    CUT_ONE_WAY = "cut_one_way"
    CUT_FLAPPING = "cut_flapping"
    CUT_ROUTER = "cut_router"
    KILL = "kill"
    KILL_TWO = "kill_two"
    KILL_LEADER = "kill_leader"
    KILL_TAIL = "kill_tail"
    KILL_AT_POINT = "kill_at_point"
    FREEZE = "freeze"
    RESTART = "restart"
    SLOW = "slow"
    OUTAGE = "outage"
    WORLD = "world"
    LATE = "late"


@dataclass(frozen=True, slots=True)
class Window:
    """Who may be struck, and until when."""

    robots: int
    until_s: float | None
    """None: faults go on to the end."""

    @property
    def begins_s(self) -> tuple[float, float]:
        """When faults may begin."""
        low_s, high_s = BEGINS_S
        return low_s, high_s if self.until_s is None else min(high_s, self.until_s - low_s)

    def ends_s(self, from_s: float, dice: Dice) -> float | None:
        """When a fault ends that began then; one in two lasts as long as it may."""
        if dice.chance(0.5):
            return self.until_s
        end_s = round(from_s + dice.scale(0.5, 15.0), 3)
        return end_s if self.until_s is None else min(end_s, self.until_s)

    def lasts_s(self, from_s: float, wished_s: float) -> float:
        """For how long something lasts that began then, and is over in time."""
        return wished_s if self.until_s is None else max(0.1, round(min(wished_s, self.until_s - from_s), 3))


class _Struck(TypedDict):
    from_s: float
    until_s: float | None


def draw_rules(fault: FaultClass, dice: Dice, window: Window) -> list[Rule]:
    """The rules of a class; the dice are its own."""
    return _DRAWS[fault](dice, window)


# --- messages -------------------------------------------------------------------------------------


def _loss(dice: Dice, window: Window) -> list[Rule]:
    from_s, until_s = _times(dice, window)
    choices: tuple[Kinds, ...] = (ALL_KINDS, ALL_KINDS, LINKS, MUSTER, LINKS + MUSTER)
    kinds = dice.pick(choices)
    return [Drop(probability=dice.scale(0.02, 0.9), kinds=kinds, from_s=from_s, until_s=until_s)]


def _delay(dice: Dice, window: Window) -> list[Rule]:
    from_s, until_s = _times(dice, window)
    most_s, probability = dice.scale(0.05, 2.5), dice.pick((1.0, 1.0, dice.between(0.05, 0.6)))
    choices: tuple[Kinds, ...] = (ALL_KINDS, LINKS, MUSTER, BODY)
    kinds = dice.pick(choices)
    return [
        Delay(delay_s_max=most_s, probability=probability, kinds=kinds, from_s=from_s, until_s=until_s),
    ]


def _late(dice: Dice, window: Window) -> list[Rule]:
    """What one robot hears of the others, or they of it, is seconds old: older than any lease."""
    from_s, until_s = _times(dice, window)
    robot = dice.pick(_names(window))
    others = tuple(name for name in _names(window) if name != robot)
    sender, receiver = (others, (robot,)) if dice.chance(0.6) else ((robot,), others)
    least_s = dice.scale(1.0, 15.0)
    return [
        Delay(
            sender=sender,
            receiver=receiver,
            delay_s_min=least_s,
            delay_s_max=round(least_s + dice.between(0.05, 2.0), 3),
            from_s=from_s,
            until_s=until_s,
        )
    ]


def _duplication(dice: Dice, window: Window) -> list[Rule]:
    from_s, until_s = _times(dice, window)
    return [
        Duplicate(
            probability=dice.between(0.05, 0.6),
            copies=dice.whole(1, 3),
            delay_s_max=dice.scale(0.1, 20.0),  # some come when their epoch is long over
            from_s=from_s,
            until_s=until_s,
        )
    ]


def _reordering(dice: Dice, window: Window) -> list[Rule]:
    from_s, until_s = _times(dice, window)
    hold_s = dice.scale(0.1, 4.0)
    return [Reorder(hold_s=hold_s, probability=dice.between(0.05, 0.4), from_s=from_s, until_s=until_s)]


def _corruption(dice: Dice, window: Window) -> list[Rule]:
    from_s, until_s = _times(dice, window)
    return [
        Corrupt(
            probability=dice.scale(0.01, 0.3),
            bits=dice.whole(1, 8),
            truncate=dice.chance(0.3),
            from_s=from_s,
            until_s=until_s,
        )
    ]


def _bursts(dice: Dice, window: Window) -> list[Rule]:
    from_s, until_s = _times(dice, window)
    burst = Burst(enter=dice.between(0.01, 0.1), leave=dice.between(0.03, 0.3), loss=dice.between(0.7, 1.0))
    return [Drop(burst=burst, from_s=from_s, until_s=until_s)]


def _body_link(dice: Dice, window: Window) -> list[Rule]:
    """Between robots and their bodies: orders, odometry, scans."""
    from_s, until_s = _times(dice, window)
    choices: tuple[Kinds, ...] = (ORDERS, ODOMETRY, BODY, SCANS, BODY + SCANS)
    kinds = dice.pick(choices)
    robots = tuple(dice.some(_names(window), dice.whole(1, window.robots)))
    sender, receiver = (robots, (WORLD,)) if dice.chance(0.5) else ((WORLD,), robots)
    if dice.chance(0.5):
        return [
            Drop(
                sender=sender,
                receiver=receiver,
                kinds=kinds,
                probability=dice.scale(0.05, 1.0),
                from_s=from_s,
                until_s=until_s,
            )
        ]
    return [
        Delay(
            sender=sender,
            receiver=receiver,
            kinds=kinds,
            delay_s_max=dice.scale(0.05, 1.5),
            from_s=from_s,
            until_s=until_s,
        )
    ]


# --- partitions -----------------------------------------------------------------------------------


def _cut_pair(dice: Dice, window: Window) -> list[Rule]:
    from_s, until_s = _times(dice, window)
    one, other = dice.some(_names(window), 2)
    return [Partition(group=(one,), others=(other,), from_s=from_s, until_s=until_s)]


def _cut_robot(dice: Dice, window: Window) -> list[Rule]:
    """One robot, or several, and the others: they show tokens, and hear nothing of each other."""
    from_s, until_s = _times(dice, window)
    group = dice.some(_names(window), dice.whole(1, window.robots - 1))
    others = tuple(robot for robot in _names(window) if robot not in group)
    return [Partition(group=tuple(group), others=others, from_s=from_s, until_s=until_s)]


def _cut_one_way(dice: Dice, window: Window) -> list[Rule]:
    from_s, until_s = _times(dice, window)
    group = dice.some(_names(window), dice.whole(1, window.robots - 1))
    others = tuple(robot for robot in _names(window) if robot not in group)
    return [Partition(group=tuple(group), others=others, one_way=True, from_s=from_s, until_s=until_s)]


def _cut_flapping(dice: Dice, window: Window) -> list[Rule]:
    from_s, until_s = _times(dice, window)
    one, other = dice.some(_names(window), 2)
    period_s = dice.between(0.4, 5.0)
    cut_s = round(period_s * dice.between(0.2, 0.9), 3)
    return [
        Partition(
            group=(one,),
            others=(other,),
            one_way=dice.chance(0.3),
            period_s=period_s,
            cut_s=cut_s,
            from_s=from_s,
            until_s=until_s,
        )
    ]


def _cut_router(dice: Dice, window: Window) -> list[Rule]:
    from_s, until_s = _times(dice, window)
    group = tuple(dice.some(_names(window), dice.whole(1, max(1, window.robots // 2))))
    return [Partition(group=group, others=(ROUTER,), from_s=from_s, until_s=until_s)]


# --- processes ------------------------------------------------------------------------------------


def _kill(dice: Dice, window: Window) -> list[Rule]:
    return [Kill(target=dice.pick(_names(window)), **_struck(dice, window))]


def _kill_two(dice: Dice, window: Window) -> list[Rule]:
    return [Kill(target=dice.pick(("leader", "middle")), robots=2, **_struck(dice, window))]


def _kill_leader(dice: Dice, window: Window) -> list[Rule]:
    """The leader; often its successor as well, as soon as there is one."""
    first = Kill(target="leader", **_struck(dice, window))
    if dice.chance(0.5):
        return [first]
    return [first, Kill(target="leader", from_s=first.from_s, until_s=window.until_s)]


def _kill_tail(dice: Dice, window: Window) -> list[Rule]:
    return [Kill(target="tail", **_struck(dice, window))]


def _kill_at_point(dice: Dice, window: Window) -> list[Rule]:
    point, occurrence = dice.pick(list(StepPoint)), dice.whole(1, 4)
    target = dice.pick((*_names(window), "leader", "middle", "tail"))
    return [Kill(target=target, point=point, occurrence=occurrence, until_s=window.until_s)]


def _freeze(dice: Dice, window: Window) -> list[Rule]:
    struck = _struck(dice, window)
    target, for_s = _anybody(dice, window), window.lasts_s(struck["from_s"], dice.scale(0.3, 10.0))
    return [Freeze(target=target, for_s=for_s, from_s=struck["from_s"], until_s=_soon_s(struck["from_s"]))]


def _restart(dice: Dice, window: Window) -> list[Rule]:
    struck = _struck(dice, window)
    target, after_s = _anybody(dice, window), window.lasts_s(struck["from_s"], dice.scale(0.1, 8.0))
    return [
        Restart(target=target, after_s=after_s, from_s=struck["from_s"], until_s=_soon_s(struck["from_s"]))
    ]


def _slow(dice: Dice, window: Window) -> list[Rule]:
    struck = _struck(dice, window)
    for_s = window.lasts_s(struck["from_s"], dice.scale(1.0, 20.0))
    return [
        Slow(
            target=_anybody(dice, window),
            delay_s=dice.scale(0.03, 1.5),
            for_s=for_s,
            from_s=struck["from_s"],
            until_s=_soon_s(struck["from_s"]),
        )
    ]


def _outage(dice: Dice, window: Window) -> list[Rule]:
    """The router is gone for a while, at most half as long as the world waits for it."""
    from_s = dice.between(*window.begins_s)
    after_s = window.lasts_s(from_s, dice.scale(0.1, 2.0))
    return [Restart(target=ROUTER, after_s=after_s, from_s=from_s)]


def _world(dice: Dice, window: Window) -> list[Rule]:
    from_s = dice.between(*window.begins_s)
    after_s = window.lasts_s(from_s, dice.scale(0.1, 2.0))
    return [Restart(target=WORLD, after_s=after_s, from_s=from_s)]


def _names(window: Window) -> Sequence[str]:
    return [robot_name(robot) for robot in range(1, window.robots + 1)]


def _anybody(dice: Dice, window: Window) -> str:
    return dice.pick((*_names(window), "leader", "middle", "tail"))


def _times(dice: Dice, window: Window) -> tuple[float, float | None]:
    """From when until when; one in three from the start."""
    from_s = 0.0 if dice.chance(0.33) else dice.between(*window.begins_s)
    return from_s, window.ends_s(from_s, dice)


def _struck(dice: Dice, window: Window) -> _Struck:
    """When a process is struck."""
    return {"from_s": dice.between(*window.begins_s), "until_s": window.until_s}


def _soon_s(from_s: float) -> float:
    """Who is not there then is spared: what began later might not be over in time."""
    return round(from_s + SOON_S, 3)


_DRAWS: dict[FaultClass, Callable[[Dice, Window], list[Rule]]] = {
    FaultClass.LOSS: _loss,
    FaultClass.DELAY: _delay,
    FaultClass.DUPLICATION: _duplication,
    FaultClass.REORDERING: _reordering,
    FaultClass.CORRUPTION: _corruption,
    FaultClass.BURSTS: _bursts,
    FaultClass.BODY_LINK: _body_link,
    FaultClass.CUT_PAIR: _cut_pair,
    FaultClass.CUT_ROBOT: _cut_robot,
    FaultClass.CUT_ONE_WAY: _cut_one_way,
    FaultClass.CUT_FLAPPING: _cut_flapping,
    FaultClass.CUT_ROUTER: _cut_router,
    FaultClass.KILL: _kill,
    FaultClass.KILL_TWO: _kill_two,
    FaultClass.KILL_LEADER: _kill_leader,
    FaultClass.KILL_TAIL: _kill_tail,
    FaultClass.KILL_AT_POINT: _kill_at_point,
    FaultClass.FREEZE: _freeze,
    FaultClass.RESTART: _restart,
    FaultClass.SLOW: _slow,
    FaultClass.OUTAGE: _outage,
    FaultClass.WORLD: _world,
    FaultClass.LATE: _late,
}
