"""The adversary's classes: faults within seconds of one moment, like those that broke safety. Pure.

Rule 1: a class draws its moment first. All of its rules lie around that, and end when the window closes.
Rule 2: each class generalises a schedule that once broke safety: bodies moved in two views, on orders of a
        former life, or over an unseen body. Every duration and every robot is drawn anew.
"""

import math
from typing import TypedDict

from clew.swarm.draws import Draws
from clew.swarm.window import SOON_S, Window, names
from protocol.faults.rules import ROUTER, Delay, Drop, Freeze, Kill, MessageKind, Partition, Restart, Rule
from protocol.keys import WORLD

EARLY_S = (0.2, 4.0)  # while robots line up for the first time and give their first orders
LATEST_S = 12.0  # most fleets have not arrived by then
ROOM_S = 5.0  # time for a token to go and come back, and for a robot that saw that to propose a view
TOKEN_GONE_S = (1.05, 7.0)  # the router's lease of a token is 1 s: a shorter cut does not lose the token


class _Times(TypedDict):
    from_s: float
    until_s: float | None


def torn(draws: Draws, window: Window) -> list[Rule]:
    """A robot is cut from the others while tokens go and come back: they propose views against each other."""
    moment_s = _moment_s(draws, window)
    one, *others = _shuffled(draws, window)
    gone_s = draws.scale(*TOKEN_GONE_S)
    since_s = _before_s(moment_s, draws.between(0.0, 3.0))
    # Long enough for the others to form a strand without it, and to drive; or as long as possible.
    lasts_s = draws.pick((math.inf, moment_s - since_s + gone_s + draws.scale(1.0, 15.0)))
    cut = Partition(group=(one,), others=tuple(others), **_within(window, since_s, lasts_s))
    gone = tuple(others) if draws.chance(0.7) else tuple(others[: draws.whole(1, len(others))])
    gone = (one,) if draws.chance(0.2) else gone
    if draws.chance(0.6):
        return [cut, Partition(group=gone, others=(ROUTER,), **_within(window, moment_s, gone_s))]
    period_s = round(gone_s + draws.scale(0.5, 6.0), 3)
    flaps = _within(window, moment_s, period_s * draws.whole(1, 4))
    return [cut, Partition(group=gone, others=(ROUTER,), period_s=period_s, cut_s=gone_s, **flaps)]


def stale_clock(draws: Draws, window: Window) -> list[Rule]:
    """A robot's clock, or its view of tokens, is stale when another robot dies or is cut off."""
    moment_s = _moment_s(draws, window)
    victim, *others = _shuffled(draws, window)
    stale = tuple(others[: 1 if draws.chance(0.6) else draws.whole(1, len(others))])
    since_s = _before_s(moment_s, draws.pick((draws.scale(0.3, 8.0), draws.between(0.9, 2.2))))
    # Ends just after the moment: then the stale robot acts before it knows how late it is.
    lasts_s = moment_s - since_s + draws.pick((draws.between(-0.2, 1.5), draws.between(0.0, 0.15)))
    around = _within(window, since_s, max(0.1, lasts_s))
    kinds: tuple[MessageKind, ...] = ("odometry", "scan") if draws.chance(0.2) else ("odometry",)
    how = draws.whole(1, 3)
    # A live fleet begins only when all robots are there.
    come = _within(window, max(SOON_S, since_s), max(0.1, lasts_s))
    blind: Rule = Partition(group=stale, others=(ROUTER,), **come)
    if how == 1:
        blind = Drop(receiver=stale, kinds=kinds, **around)
    elif how == 2:
        most_s = draws.between(0.3, 2.0)
        blind = Delay(receiver=stale, kinds=kinds, delay_s_min=most_s / 2, delay_s_max=most_s, **around)
    return [blind, _lost(victim, draws, window, moment_s)]


def former_orders(draws: Draws, window: Window) -> list[Rule]:
    """A robot's orders are late, and it is restarted once or twice, often early; or it dies."""
    robot, least_s = draws.pick(names(window)), draws.scale(0.3, 3.0)
    moment_s = draws.between(*EARLY_S) if draws.chance(0.5) else _moment_s(draws, window)
    dies = draws.chance(0.4)
    if not dies and draws.chance(0.6):  # the head of a queue orders first; bodies accept it within 1 s
        robot, least_s, moment_s = names(window)[0], draws.between(0.4, 0.95), draws.between(0.15, 0.9)
    late = Delay(
        sender=(robot,),
        kinds=("drive",),
        delay_s_min=least_s,
        delay_s_max=round(least_s + draws.scale(0.02, 0.4), 3),
        **_within(window, _before_s(moment_s, draws.scale(0.5, 10.0)), draws.scale(5.0, 60.0)),
    )
    loss = _lost(robot, draws, window, moment_s) if dies else _restart(robot, draws, window, moment_s)
    rules: list[Rule] = [late, loss]
    if not dies and draws.chance(0.6):
        rules.append(_restart(robot, draws, window, round(moment_s + draws.scale(0.5, 40.0), 3)))
    return rules


def hidden_body(draws: Draws, window: Window) -> list[Rule]:
    """A robot is restarted, and its neighbour dies or is frozen: one body may hide the other."""
    moment_s = draws.between(*EARLY_S) if draws.chance(0.5) else _moment_s(draws, window)
    robots = names(window)
    between = len(robots) > 3 and draws.chance(0.6)  # with a robot ahead of both and one behind both
    place = draws.whole(2, len(robots) - 2) if between else draws.whole(1, len(robots) - 1)
    two = (robots[place], robots[place - 1]) if draws.chance(0.8) else (robots[place - 1], robots[place])
    dies_s = round(moment_s + draws.pick((draws.between(-0.3, 2.5), draws.between(0.1, 0.8))), 3)
    loss = _lost(two[1], draws, window, max(0.0, dies_s))
    return [_restart(two[0], draws, window, moment_s), loss]


def unseen_death(draws: Draws, window: Window) -> list[Rule]:
    """A robot dies or is restarted while the world's process is down."""
    moment_s = _moment_s(draws, window)
    after_s = window.lasts_s(moment_s, draws.between(0.4, 2.0))  # a run waits twice as long for its world
    robot = draws.pick(names(window))
    lost_s = round(moment_s + after_s * draws.between(0.0, 1.0), 3)
    down = Restart(target=WORLD, after_s=after_s, from_s=moment_s)
    if draws.chance(0.7):
        return [down, Kill(target=robot, from_s=lost_s, until_s=round(lost_s + SOON_S, 3))]
    return [down, _restart(robot, draws, window, lost_s)]


def blind_start(draws: Draws, window: Window) -> list[Rule]:
    """A robot is restarted and gets its first odometry late; often another robot dies."""
    moment_s = _moment_s(draws, window)
    robot, other = _shuffled(draws, window)[:2]
    again = _restart(robot, draws, window, moment_s)
    since_s = _before_s(moment_s, draws.scale(0.2, 6.0))
    lasts_s = moment_s - since_s + again.after_s + draws.scale(0.2, 6.0)
    blind = Drop(receiver=(robot,), kinds=("odometry",), **_within(window, since_s, lasts_s))
    if draws.chance(0.5):
        return [blind, again]
    return [
        blind,
        again,
        _lost(other, draws, window, max(0.0, round(moment_s + draws.between(-2.0, 3.0), 3))),
    ]


def late_lease(draws: Draws, window: Window) -> list[Rule]:
    """A robot is cut off while a view forms, the orders of the others are late, and it comes back."""
    moment_s = draws.between(*EARLY_S) if draws.chance(0.6) else _moment_s(draws, window)
    robot, *others = _shuffled(draws, window)
    away_s = draws.scale(0.3, 8.0)
    cut = Partition(group=(robot,), others=(ROUTER,), **_within(window, max(SOON_S, moment_s), away_s))
    least_s = draws.scale(0.2, 3.0)
    late = Delay(
        sender=tuple(others),
        kinds=("drive", "turn") if draws.chance(0.4) else ("drive",),
        delay_s_min=least_s,
        delay_s_max=round(least_s + draws.scale(0.02, 1.0), 3),
        **_within(window, _before_s(moment_s, draws.scale(0.1, 5.0)), away_s + draws.scale(1.0, 10.0)),
    )
    if draws.chance(0.6):
        return [cut, late]
    back_s = round(max(SOON_S, moment_s) + away_s, 3)
    return [cut, late, _lost(draws.pick(others), draws, window, back_s)]


# --- parts ----------------------------------------------------------------------------------------


def _moment_s(draws: Draws, window: Window) -> float:
    """A moment that leaves time for what follows, before fleets have arrived."""
    low_s, high_s = window.begins_s
    closes_s = math.inf if window.until_s is None else window.until_s
    return draws.between(low_s, min(high_s, max(low_s + SOON_S, closes_s - ROOM_S), LATEST_S))


def _before_s(moment_s: float, by_s: float) -> float:
    return max(0.0, round(moment_s - by_s, 3))


def _within(window: Window, from_s: float, lasts_s: float) -> _Times:
    """The times of a fault of this duration, which ends when the window closes."""
    end_s = min(round(from_s + lasts_s, 3), math.inf if window.until_s is None else window.until_s)
    return {"from_s": from_s, "until_s": None if math.isinf(end_s) else end_s}


def _shuffled(draws: Draws, window: Window) -> list[str]:
    robots = list(names(window))
    first = draws.pick(robots)
    rest = [robot for robot in robots if robot != first]
    second = draws.pick(rest)
    return [first, second, *(robot for robot in rest if robot != second)]


def _restart(robot: str, draws: Draws, window: Window, from_s: float) -> Restart:
    """Restart the robot at this time, with or without a delay."""
    from_s = from_s if window.until_s is None else min(from_s, round(window.until_s - SOON_S, 3))
    after_s = window.lasts_s(from_s, draws.pick((0.0, draws.scale(0.02, 3.0))))
    return Restart(target=robot, after_s=after_s, from_s=from_s, until_s=round(from_s + SOON_S, 3))


def _lost(robot: str, draws: Draws, window: Window, from_s: float) -> Rule:
    """The others lose the robot at this time; in half of the cases it is dead."""
    from_s = from_s if window.until_s is None else min(from_s, round(window.until_s - SOON_S, 3))
    from_s = max(SOON_S, from_s)  # before it has started there is no fleet yet
    soon_s = round(from_s + SOON_S, 3)
    gone_s = draws.scale(*TOKEN_GONE_S)
    match draws.whole(1, 6):
        case 1:
            for_s = window.lasts_s(from_s, gone_s)
            return Freeze(target=robot, for_s=for_s, from_s=from_s, until_s=soon_s)
        case 2:
            return _restart(robot, draws, window, from_s)
        case 3:
            return Partition(group=(robot,), others=(ROUTER,), **_within(window, from_s, gone_s))
        case _:
            return Kill(target=robot, from_s=from_s, until_s=soon_s)
