"""Message faults of a swarm: draws the rules of each class. Pure."""

from clew.swarm.draws import Draws
from clew.swarm.window import Window, names, times
from protocol.faults.rules import (
    ROUTER,
    Burst,
    Corrupt,
    Delay,
    Drop,
    Duplicate,
    MessageKind,
    Partition,
    Reorder,
    Rule,
)
from protocol.keys import WORLD

Kinds = tuple[MessageKind, ...]

ALL_KINDS: Kinds = ()
LINKS: Kinds = ("ahead", "behind")
VIEWS: Kinds = ("report", "answer", "formation", "plea")
FENCE: Kinds = ("raise", "turn")
BODY: Kinds = ("drive", "odometry")
ORDERS: Kinds = ("drive",)
ODOMETRY: Kinds = ("odometry",)
SCANS: Kinds = ("scan", "scan_query")


def loss(draws: Draws, window: Window) -> list[Rule]:
    """Messages are lost independently."""
    from_s, until_s = times(draws, window)
    choices: tuple[Kinds, ...] = (ALL_KINDS, ALL_KINDS, LINKS, VIEWS, LINKS + VIEWS)
    kinds = draws.pick(choices)
    return [Drop(probability=draws.scale(0.02, 0.9), kinds=kinds, from_s=from_s, until_s=until_s)]


def delay(draws: Draws, window: Window) -> list[Rule]:
    """Messages are late, each by its own delay."""
    from_s, until_s = times(draws, window)
    most_s, probability = draws.scale(0.05, 2.5), draws.pick((1.0, 1.0, draws.between(0.05, 0.6)))
    choices: tuple[Kinds, ...] = (ALL_KINDS, LINKS, VIEWS, BODY)
    kinds = draws.pick(choices)
    return [
        Delay(delay_s_max=most_s, probability=probability, kinds=kinds, from_s=from_s, until_s=until_s),
    ]


def late(draws: Draws, window: Window) -> list[Rule]:
    """Messages to one robot, or from it, are seconds old: older than any lease."""
    from_s, until_s = times(draws, window)
    robot = draws.pick(names(window))
    others = tuple(name for name in names(window) if name != robot)
    sender, receiver = (others, (robot,)) if draws.chance(0.6) else ((robot,), others)
    least_s = draws.scale(1.0, 15.0)
    return [
        Delay(
            sender=sender,
            receiver=receiver,
            delay_s_min=least_s,
            delay_s_max=round(least_s + draws.between(0.05, 2.0), 3),
            from_s=from_s,
            until_s=until_s,
        )
    ]


def duplication(draws: Draws, window: Window) -> list[Rule]:
    """Messages are duplicated; some copies arrive when their epoch is long over."""
    from_s, until_s = times(draws, window)
    return [
        Duplicate(
            probability=draws.between(0.05, 0.6),
            copies=draws.whole(1, 3),
            delay_s_max=draws.scale(0.1, 20.0),
            from_s=from_s,
            until_s=until_s,
        )
    ]


def reordering(draws: Draws, window: Window) -> list[Rule]:
    """Messages are held back, so that later ones overtake them."""
    from_s, until_s = times(draws, window)
    hold_s = draws.scale(0.1, 4.0)
    return [Reorder(hold_s=hold_s, probability=draws.between(0.05, 0.4), from_s=from_s, until_s=until_s)]


def corruption(draws: Draws, window: Window) -> list[Rule]:
    """Messages are damaged."""
    from_s, until_s = times(draws, window)
    return [
        Corrupt(
            probability=draws.scale(0.01, 0.3),
            bits=draws.whole(1, 8),
            truncate=draws.chance(0.3),
            from_s=from_s,
            until_s=until_s,
        )
    ]


def bursts(draws: Draws, window: Window) -> list[Rule]:
    """Messages are lost in bursts."""
    from_s, until_s = times(draws, window)
    burst = Burst(
        enter=draws.between(0.01, 0.1), leave=draws.between(0.03, 0.3), loss=draws.between(0.7, 1.0)
    )
    return [Drop(burst=burst, from_s=from_s, until_s=until_s)]


def body_link(draws: Draws, window: Window) -> list[Rule]:
    """Faults between robots and their bodies: of orders, odometry and scans."""
    from_s, until_s = times(draws, window)
    choices: tuple[Kinds, ...] = (ORDERS, ODOMETRY, BODY, SCANS, BODY + SCANS)
    kinds = draws.pick(choices)
    robots = tuple(draws.some(names(window), draws.whole(1, window.robots)))
    to_body = (draws.chance(0.5) or kinds == ORDERS) and kinds != ODOMETRY
    sender, receiver = (robots, (WORLD,)) if to_body else ((WORLD,), robots)
    if draws.chance(0.5):
        return [
            Drop(
                sender=sender,
                receiver=receiver,
                kinds=kinds,
                probability=draws.scale(0.05, 1.0),
                from_s=from_s,
                until_s=until_s,
            )
        ]
    return [
        Delay(
            sender=sender,
            receiver=receiver,
            kinds=kinds,
            delay_s_max=draws.scale(0.05, 1.5),
            from_s=from_s,
            until_s=until_s,
        )
    ]


def fence_link(draws: Draws, window: Window) -> list[Rule]:
    """Faults on the way to the fence: what some robots put is lost, late, or comes again much later."""
    from_s, until_s = times(draws, window)
    robots = tuple(draws.some(names(window), draws.whole(1, window.robots)))
    choices: tuple[Kinds, ...] = (FENCE, FENCE, FENCE + ORDERS, ("turn",), ("raise",))
    kinds = draws.pick(choices)
    match draws.whole(1, 3):
        case 1:
            lost = draws.scale(0.1, 1.0)
            return [Drop(sender=robots, kinds=kinds, probability=lost, from_s=from_s, until_s=until_s)]
        case 2:
            most_s = draws.scale(0.1, 5.0)
            return [Delay(sender=robots, kinds=kinds, delay_s_max=most_s, from_s=from_s, until_s=until_s)]
        case _:
            most_s = draws.scale(0.1, 20.0)
            return [Duplicate(sender=robots, kinds=kinds, delay_s_max=most_s, from_s=from_s, until_s=until_s)]


# --- partitions -----------------------------------------------------------------------------------


def cut_pair(draws: Draws, window: Window) -> list[Rule]:
    """Two robots do not receive each other's messages."""
    from_s, until_s = times(draws, window)
    one, other = draws.some(names(window), 2)
    return [Partition(group=(one,), others=(other,), from_s=from_s, until_s=until_s)]


def cut_robot(draws: Draws, window: Window) -> list[Rule]:
    """One or several robots are cut from the others. All keep their tokens."""
    from_s, until_s = times(draws, window)
    group = draws.some(names(window), draws.whole(1, window.robots - 1))
    others = tuple(robot for robot in names(window) if robot not in group)
    return [Partition(group=tuple(group), others=others, from_s=from_s, until_s=until_s)]


def cut_one_way(draws: Draws, window: Window) -> list[Rule]:
    """Messages from some robots to the others are lost; those back arrive."""
    from_s, until_s = times(draws, window)
    group = draws.some(names(window), draws.whole(1, window.robots - 1))
    others = tuple(robot for robot in names(window) if robot not in group)
    return [Partition(group=tuple(group), others=others, one_way=True, from_s=from_s, until_s=until_s)]


def cut_flapping(draws: Draws, window: Window) -> list[Rule]:
    """Two robots are cut from each other again and again."""
    from_s, until_s = times(draws, window)
    one, other = draws.some(names(window), 2)
    period_s = draws.between(0.4, 5.0)
    cut_s = round(period_s * draws.between(0.2, 0.9), 3)
    return [
        Partition(
            group=(one,),
            others=(other,),
            one_way=draws.chance(0.3),
            period_s=period_s,
            cut_s=cut_s,
            from_s=from_s,
            until_s=until_s,
        )
    ]


def cut_router(draws: Draws, window: Window) -> list[Rule]:
    """Some robots are cut off from the router, and so from all others, but not before they have started."""
    from_s = draws.between(*window.begins_s)  # a live fleet that is not complete at the start never begins
    until_s = window.ends_s(from_s, draws)
    group = tuple(draws.some(names(window), draws.whole(1, max(1, window.robots // 2))))
    return [Partition(group=group, others=(ROUTER,), from_s=from_s, until_s=until_s)]
