"""Strikes: faults within a second or two of one moment, on the messages that a view change needs. Pure.

Rule 1: most faults of a strike affect one robot, since most breaches need two faults that meet, such as an
        order that is late and the death of its robot.
Rule 2: times count from the moment. All faults of messages are short, so that the fleet acts on what remains.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass

from clew.swarm.draws import Draws
from clew.swarm.messages import LINKS, Kinds
from clew.swarm.window import SOON_S, Window, names
from protocol.faults.rules import (
    ROUTER,
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

EVENT, MESSAGES = 0.75, 0.75  # how often a strike has a fault of a process, and of messages; one at least
MORE = 0.25  # how often it has a further one
AIMED = 0.75  # share of faults that affect the robot in focus
KINDS: tuple[Kinds, ...] = (
    *(("drive",),) * 5,
    *(("turn",),) * 2,
    *(("raise",),) * 2,
    ("drive", "turn", "raise"),
    *(("odometry",),) * 3,
    *(("scan",),) * 2,
    ("report",),
    ("answer",),
    ("formation",),
    *(LINKS,) * 2,
    (),
)
FROM_WORLD: frozenset[MessageKind] = frozenset({"odometry", "scan"})
BRIEF_S = (0.05, 0.5)
JUST_VALID_S = (0.5, 1.0)  # a body refuses an order whose basis is 1 s old
VOID_S = (1.0, 3.0)
LASTS_S = (0.1, 2.0)
BEGINS_S = (0.0, 0.6)  # before the next reports, answers and turns
AWAY_S = (0.05, 1.5)
CUT_S = (0.3, 5.0)  # the router's lease of a token is 1 s


@dataclass(frozen=True, slots=True)
class _Aim:
    """What a strike affects."""

    draws: Draws
    robots: Sequence[str]
    focus: str

    def robot(self) -> str:
        return self.focus if self.draws.chance(AIMED) else self.draws.pick(self.robots)

    def from_s(self) -> float:
        return 0.0 if self.draws.chance(0.5) else self.draws.between(*BEGINS_S)

    def late_s(self) -> float:
        return self.draws.scale(*self.draws.pick((BRIEF_S, JUST_VALID_S, VOID_S)))


def strike(draws: Draws, window: Window, robot: int) -> list[Rule]:
    """The faults of a strike on this robot."""
    aim = _Aim(draws, names(window), robot_name(robot))
    event, messages = draws.chance(EVENT), draws.chance(MESSAGES)
    rules = [draws.pick(_PROCESSES)(aim)] if event or not messages else []
    rules += [_of_messages(aim)] if messages else []
    if draws.chance(MORE):
        rules.append(_of_messages(aim) if draws.chance(0.5) else draws.pick(_PROCESSES)(aim))
    return rules


def _of_messages(aim: _Aim) -> Rule:
    """Messages of some kinds, of one robot or of all, are lost, late or twice there."""
    draws = aim.draws
    kinds = draws.pick(KINDS)
    one: tuple[str, ...] = (aim.robot(),) if draws.chance(0.8) else ()
    from_s = aim.from_s()
    until_s, late_s = round(from_s + draws.scale(*LASTS_S), 3), aim.late_s()
    sender, receiver = ((), one) if kinds and kinds[0] in FROM_WORLD else (one, ())
    match draws.whole(1, 4):
        case 1:
            return Drop(sender=sender, receiver=receiver, kinds=kinds, from_s=from_s, until_s=until_s)
        case 2:
            return Duplicate(
                sender=sender,
                receiver=receiver,
                kinds=kinds,
                delay_s_max=late_s,
                from_s=from_s,
                until_s=until_s,
            )
        case _:
            return Delay(
                sender=sender,
                receiver=receiver,
                kinds=kinds,
                delay_s_min=round(late_s * 0.9, 3),
                delay_s_max=late_s,
                from_s=from_s,
                until_s=until_s,
            )


def _kill(aim: _Aim) -> Rule:
    from_s = aim.draws.between(*BEGINS_S)
    return Kill(target=aim.robot(), from_s=from_s, until_s=round(from_s + SOON_S, 3))


def _restart(aim: _Aim) -> Rule:
    from_s = aim.draws.between(*BEGINS_S)
    after_s = aim.draws.pick((0.0, aim.draws.scale(*AWAY_S)))
    return Restart(target=aim.robot(), after_s=after_s, from_s=from_s, until_s=round(from_s + SOON_S, 3))


def _freeze(aim: _Aim) -> Rule:
    from_s = aim.draws.between(*BEGINS_S)
    for_s = aim.draws.scale(*AWAY_S)
    return Freeze(target=aim.robot(), for_s=for_s, from_s=from_s, until_s=round(from_s + SOON_S, 3))


def _cut(aim: _Aim) -> Rule:
    """One of the robots is cut off from all others, with or without the world."""
    from_s = aim.from_s()
    others = (ROUTER,) if aim.draws.chance(0.5) else tuple(each for each in aim.robots)
    one = aim.robot()
    return Partition(
        group=(one,),
        others=tuple(each for each in others if each != one),
        from_s=from_s,
        until_s=round(from_s + aim.draws.scale(*CUT_S), 3),
    )


def _world(aim: _Aim) -> Rule:
    return Restart(target=WORLD, after_s=aim.draws.scale(0.1, 1.0), from_s=aim.draws.between(*BEGINS_S))


_PROCESSES: tuple[Callable[[_Aim], Rule], ...] = (
    _kill,
    _kill,
    _restart,
    _restart,
    _freeze,
    _cut,
    _cut,
    _world,
)
