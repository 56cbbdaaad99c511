"""What a swarm does to processes: how the rules of each class are drawn. Pure."""

from typing import TypedDict

from clew.swarm.dice import Dice
from clew.swarm.window import SOON_S, Window, names
from protocol.faults.rules import ROUTER, Freeze, Kill, Restart, Rule, Slow, StepPoint
from protocol.keys import WORLD


class _Struck(TypedDict):
    from_s: float
    until_s: float | None


def kill(dice: Dice, window: Window) -> list[Rule]:
    """One robot dies."""
    return [Kill(target=dice.pick(names(window)), **_struck(dice, window))]


def kill_two(dice: Dice, window: Window) -> list[Rule]:
    """Two neighbours die at once."""
    return [Kill(target=dice.pick(("leader", "middle")), robots=2, **_struck(dice, window))]


def kill_leader(dice: Dice, window: Window) -> list[Rule]:
    """The leader; often its successor as well, as soon as there is one."""
    first = Kill(target="leader", **_struck(dice, window))
    if dice.chance(0.5):
        return [first]
    return [first, Kill(target="leader", from_s=first.from_s, until_s=window.until_s)]


def kill_tail(dice: Dice, window: Window) -> list[Rule]:
    """The tail dies."""
    return [Kill(target="tail", **_struck(dice, window))]


def kill_at_point(dice: Dice, window: Window) -> list[Rule]:
    """A robot dies at a point of its step."""
    point, occurrence = dice.pick(list(StepPoint)), dice.whole(1, 4)
    target = dice.pick((*names(window), "leader", "middle", "tail"))
    return [Kill(target=target, point=point, occurrence=occurrence, until_s=window.until_s)]


def freeze(dice: Dice, window: Window) -> list[Rule]:
    """A robot is frozen, and thaws."""
    struck = _struck(dice, window)
    target, for_s = _anybody(dice, window), window.lasts_s(struck["from_s"], dice.scale(0.3, 10.0))
    return [Freeze(target=target, for_s=for_s, from_s=struck["from_s"], until_s=_soon_s(struck["from_s"]))]


def restart(dice: Dice, window: Window) -> list[Rule]:
    """A robot dies, and another process takes its place."""
    struck = _struck(dice, window)
    target, after_s = _anybody(dice, window), window.lasts_s(struck["from_s"], dice.scale(0.1, 8.0))
    return [
        Restart(target=target, after_s=after_s, from_s=struck["from_s"], until_s=_soon_s(struck["from_s"]))
    ]


def slow(dice: Dice, window: Window) -> list[Rule]:
    """A robot takes its time for a while."""
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


def outage(dice: Dice, window: Window) -> list[Rule]:
    """The router is gone for a while, at most half as long as the world waits for it."""
    from_s = dice.between(*window.begins_s)
    after_s = window.lasts_s(from_s, dice.scale(0.1, 2.0))
    return [Restart(target=ROUTER, after_s=after_s, from_s=from_s)]


def world(dice: Dice, window: Window) -> list[Rule]:
    """The world's process dies, and another takes its place."""
    from_s = dice.between(*window.begins_s)
    after_s = window.lasts_s(from_s, dice.scale(0.1, 2.0))
    return [Restart(target=WORLD, after_s=after_s, from_s=from_s)]


def _anybody(dice: Dice, window: Window) -> str:
    return dice.pick((*names(window), "leader", "middle", "tail"))


def _struck(dice: Dice, window: Window) -> _Struck:
    """When a process is struck."""
    return {"from_s": dice.between(*window.begins_s), "until_s": window.until_s}


def _soon_s(from_s: float) -> float:
    """Who is not there then is spared: what began later might not be over in time."""
    return round(from_s + SOON_S, 3)
