"""Process faults of a swarm: draws the rules of each class. Pure."""

from typing import TypedDict

from clew.swarm.draws import Draws
from clew.swarm.window import SOON_S, Window, names
from protocol.faults.rules import ROUTER, Freeze, Kill, Restart, Rule, Slow, StepPoint
from protocol.keys import WORLD


class _When(TypedDict):
    from_s: float
    until_s: float | None


def kill(draws: Draws, window: Window) -> list[Rule]:
    """One robot dies."""
    return [Kill(target=draws.pick(names(window)), **_when(draws, window))]


def kill_two(draws: Draws, window: Window) -> list[Rule]:
    """Two neighbours die at once."""
    return [Kill(target=draws.pick(("leader", "middle")), robots=2, **_when(draws, window))]


def kill_leader(draws: Draws, window: Window) -> list[Rule]:
    """The leader dies; often also its successor, as soon as there is one."""
    first = Kill(target="leader", **_when(draws, window))
    if draws.chance(0.5):
        return [first]
    return [first, Kill(target="leader", from_s=first.from_s, until_s=window.until_s)]


def kill_tail(draws: Draws, window: Window) -> list[Rule]:
    """The tail dies."""
    return [Kill(target="tail", **_when(draws, window))]


def lose_coordinator(draws: Draws, window: Window) -> list[Rule]:
    """The coordinator of a view dies, freezes or is restarted, often early; often the next one dies, too."""
    from_s = draws.between(SOON_S, 4.0) if draws.chance(0.5) else draws.between(*window.begins_s)
    match draws.whole(1, 3):
        case 1:
            first: Rule = Kill(target="coordinator", from_s=from_s, until_s=window.until_s)
        case 2:
            for_s = window.lasts_s(from_s, draws.scale(0.3, 10.0))
            first = Freeze(target="coordinator", for_s=for_s, from_s=from_s, until_s=_soon_s(from_s))
        case _:
            after_s = window.lasts_s(from_s, draws.pick((0.0, draws.scale(0.02, 3.0))))
            first = Restart(target="coordinator", after_s=after_s, from_s=from_s, until_s=_soon_s(from_s))
    if draws.chance(0.6):
        return [first]
    return [first, Kill(target="coordinator", from_s=from_s, until_s=window.until_s)]


def kill_at_point(draws: Draws, window: Window) -> list[Rule]:
    """A robot dies at a point of its step."""
    point, occurrence = draws.pick(list(StepPoint)), draws.whole(1, 4)
    target = draws.pick((*names(window), "leader", "middle", "tail", "coordinator"))
    return [Kill(target=target, point=point, occurrence=occurrence, until_s=window.until_s)]


def freeze(draws: Draws, window: Window) -> list[Rule]:
    """A robot is frozen, and thaws."""
    when = _when(draws, window)
    target, for_s = _any_target(draws, window), window.lasts_s(when["from_s"], draws.scale(0.3, 10.0))
    return [Freeze(target=target, for_s=for_s, from_s=when["from_s"], until_s=_soon_s(when["from_s"]))]


def restart(draws: Draws, window: Window) -> list[Rule]:
    """A robot dies, and another process takes its place."""
    when = _when(draws, window)
    target, after_s = _any_target(draws, window), window.lasts_s(when["from_s"], draws.scale(0.1, 8.0))
    return [Restart(target=target, after_s=after_s, from_s=when["from_s"], until_s=_soon_s(when["from_s"]))]


def slow(draws: Draws, window: Window) -> list[Rule]:
    """A robot is slow for a while."""
    when = _when(draws, window)
    for_s = window.lasts_s(when["from_s"], draws.scale(1.0, 20.0))
    return [
        Slow(
            target=_any_target(draws, window),
            delay_s=draws.scale(0.03, 1.5),
            for_s=for_s,
            from_s=when["from_s"],
            until_s=_soon_s(when["from_s"]),
        )
    ]


def outage(draws: Draws, window: Window) -> list[Rule]:
    """The router is down for a while, at most half as long as the world waits for it."""
    from_s = draws.between(*window.begins_s)
    after_s = window.lasts_s(from_s, draws.scale(0.1, 2.0))
    return [Restart(target=ROUTER, after_s=after_s, from_s=from_s)]


def world(draws: Draws, window: Window) -> list[Rule]:
    """The world's process dies, and another takes its place."""
    from_s = draws.between(*window.begins_s)
    after_s = window.lasts_s(from_s, draws.scale(0.1, 2.0))
    return [Restart(target=WORLD, after_s=after_s, from_s=from_s)]


def _any_target(draws: Draws, window: Window) -> str:
    return draws.pick((*names(window), "leader", "middle", "tail"))


def _when(draws: Draws, window: Window) -> _When:
    """When the fault of a process begins, and the end of its window."""
    return {"from_s": draws.between(*window.begins_s), "until_s": window.until_s}


def _soon_s(from_s: float) -> float:
    """The end of a short window. A target that is absent is spared: a later fault might not end in time."""
    return round(from_s + SOON_S, 3)
