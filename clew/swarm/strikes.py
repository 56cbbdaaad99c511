"""A strike: at most one fault of a process and two of messages, within two seconds. Pure.

Rule 1: most faults of a strike affect the robot in focus: most breaches need two faults that meet, such as an
        order that is late and the restart of its robot.
Rule 2: times count from the moment. Faults of messages begin with it and are short, so that the fleet acts
        on what remains.
Rule 3: late messages each have their own delay, or all nearly the same one. So some arrive in another order,
        and some arrive together, in a later epoch.
"""

from collections.abc import Callable
from dataclasses import dataclass
from typing import TypedDict

from clew.swarm.draws import Draws
from clew.swarm.messages import LINKS, VIEWS, Kinds
from clew.swarm.window import SOON_S, Window, names
from protocol.faults.rules import (
    ROUTER,
    Corrupt,
    Delay,
    Drop,
    Duplicate,
    Freeze,
    Kill,
    MessageKind,
    Partition,
    Restart,
    Rule,
)
from protocol.keys import WORLD, robot_name

EVENT = 0.85  # how often a strike has a fault of a process
MESSAGES = (0, 1, 1, 2, 2)  # how many faults of messages; at least one if there is none of a process
AIMED = 0.8  # share of faults of processes that affect the robot in focus
KINDS: tuple[Kinds, ...] = (
    *((),) * 2,
    *(("drive",),) * 3,
    *(("raise", "turn"),) * 3,
    ("odometry",),
    ("scan",),
    VIEWS,
    LINKS,
)
TO_WORLD: frozenset[MessageKind] = frozenset({"drive", "raise"})
FROM_WORLD: frozenset[MessageKind] = frozenset({"odometry", "scan"})
BEGINS_S = (0.0, 0.8)  # before the next reports, answers and turns, or soon after
LATE_S = (0.2, 2.0)  # a body refuses an order whose basis is 1 s old; a view takes less
LASTS_S = (0.1, 2.0)
AWAY_S = (0.05, 1.5)
CUT_S = (0.1, 4.0)  # the router's lease of a token is 1 s


class _Limits(TypedDict):
    sender: tuple[str, ...]
    receiver: tuple[str, ...]
    kinds: Kinds
    until_s: float


@dataclass(frozen=True, slots=True)
class _Aim:
    """What a strike affects."""

    draws: Draws
    robots: tuple[str, ...]
    focus: str

    def robot(self) -> str:
        return self.focus if self.draws.chance(AIMED) else self.draws.pick(self.robots)

    def begins_s(self) -> float:
        return self.draws.between(*BEGINS_S)


def strike(draws: Draws, window: Window, robot: int) -> list[Rule]:
    """The faults of a strike on this robot."""
    aim = _Aim(draws, tuple(names(window)), robot_name(robot))
    events = [draws.pick(_EVENTS)(aim)] if draws.chance(EVENT) else []
    messages = max(draws.pick(MESSAGES), 1 - len(events))
    return [*events, *(_of_messages(aim) for _ in range(messages))]


def _of_messages(aim: _Aim) -> Rule:
    """Messages of some kinds, from or to one robot or all, are late, lost, damaged or twice there."""
    draws = aim.draws
    kinds, whose = draws.pick(KINDS), draws.pick(((aim.focus,), (draws.pick(aim.robots),), ()))
    is_from = draws.chance(0.5)
    if kinds and kinds[0] in TO_WORLD | FROM_WORLD:
        is_from = kinds[0] in TO_WORLD
    sender, receiver = (whose, ()) if is_from else ((), whose)
    until_s, late_s = draws.scale(*LASTS_S), draws.scale(*LATE_S)
    limits: _Limits = {"sender": sender, "receiver": receiver, "kinds": kinds, "until_s": until_s}
    match draws.whole(1, 12):
        case 1:
            return Drop(**limits)
        case 2:
            return Duplicate(delay_s_max=late_s, **limits)
        case 3 | 4:
            return Corrupt(bits=draws.whole(1, 8), **limits)
        case each if each % 2:
            return Delay(delay_s_max=late_s, **limits)
        case _:
            return Delay(delay_s_min=round(late_s * 0.95, 3), delay_s_max=late_s, **limits)


def _kill(aim: _Aim) -> Rule:
    from_s = aim.begins_s()
    return Kill(target=aim.robot(), from_s=from_s, until_s=round(from_s + SOON_S, 3))


def _restart(aim: _Aim) -> Rule:
    from_s = aim.begins_s()
    after_s = aim.draws.pick((0.0, aim.draws.scale(*AWAY_S)))
    return Restart(target=aim.robot(), after_s=after_s, from_s=from_s, until_s=round(from_s + SOON_S, 3))


def _freeze(aim: _Aim) -> Rule:
    from_s = aim.begins_s()
    for_s = aim.draws.scale(*AWAY_S)
    return Freeze(target=aim.robot(), for_s=for_s, from_s=from_s, until_s=round(from_s + SOON_S, 3))


def _cut(aim: _Aim) -> Rule:
    from_s = aim.begins_s()
    until_s = round(from_s + aim.draws.scale(*CUT_S), 3)
    return Partition(group=(aim.robot(),), others=(ROUTER,), from_s=from_s, until_s=until_s)


def _world(aim: _Aim) -> Rule:
    return Restart(target=WORLD, after_s=aim.draws.scale(0.1, 1.0), from_s=aim.begins_s())


_EVENTS: tuple[Callable[[_Aim], Rule], ...] = (*(_restart,) * 5, _kill, _freeze, _cut, _world)
