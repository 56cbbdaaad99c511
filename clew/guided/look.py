"""Looks at a rehearsal for its cells: the states of its robots, and the faults in progress."""

from collections.abc import Collection, Iterator, Sequence
from dataclasses import dataclass
from typing import assert_never

from agents.membership.states import State
from agents.robot import Robot
from clew.guided.cells import Cell, cells
from clew.rehearsal.actor import Actor
from clew.rehearsal.rehearsal import Rehearsal
from protocol.faults.plan import Plan
from protocol.faults.rules import ROUTER, MessageRule, Partition
from protocol.fence import Fence, May
from protocol.keys import WORLD, robot_name


@dataclass(frozen=True, slots=True)
class Sight:
    """A robot, as a cell needs it."""

    robot: int
    state: str
    fence: tuple[int, int, int] = (-1, 0, 0)
    role: str = ""
    drives: bool = False
    named: Collection[int] = ()
    bound: Collection[int] = ()
    silent: Collection[int] = ()


def look(rehearsal: Rehearsal) -> set[Cell]:
    """The cells that the rehearsal is in now."""
    fleet = range(1, rehearsal.world.scenario.fleet.robots + 1)
    actors = rehearsal.processes.actors
    moving = rehearsal.world.bodies.moving
    sights = [_sight(robot, actors.get(robot), fleet, moving=bool(moving[robot - 1])) for robot in fleet]
    return set(cells(sights, Faults(rehearsal)))


class Faults:
    """The faults in progress in a rehearsal."""

    def __init__(self, rehearsal: Rehearsal) -> None:
        now_s = rehearsal.world.now_s
        self._processes = rehearsal.processes
        active = [rule for rule in message_rules(rehearsal.plan) if rule.holds(now_s, 0)]
        self._cuts = [rule for rule in active if isinstance(rule, Partition)]
        self._others = [rule for rule in active if not isinstance(rule, Partition)]
        self._mute = self._processes.desk.ended or not self._processes.router_is_up

    def of(self, robot: int) -> str:
        """The worst that a robot suffers now."""
        actor, name = self._processes.actors.get(robot), robot_name(robot)
        if actor is not None and actor.frozen:
            return "frozen"
        if self._mute:
            return "mute"
        if any(_is_cut(rule, name, ROUTER) for rule in self._cuts):
            return "cut"
        if any(_is_cut(rule, name, WORLD) for rule in self._cuts):
            return "blind"
        if actor is not None and actor.delay_s > 0.0:
            return "slow"
        lossy = any(name in _limits(rule) or not _limits(rule) for rule in self._others)
        return "lossy" if lossy else ""

    def between(self, one: int, other: int) -> bool:
        """Whether messages from one robot to the other are cut off."""
        return any(rule.cuts(robot_name(one), robot_name(other)) for rule in self._cuts)


def message_rules(plan: Plan) -> Iterator[MessageRule]:
    """The rules of the plan for messages."""
    return (rule for rule in plan.rules if isinstance(rule, MessageRule))


def _is_cut(rule: Partition, name: str, other: str) -> bool:
    return rule.cuts(name, other) or rule.cuts(other, name)


def _limits(rule: MessageRule) -> Sequence[str]:
    """The processes that the rule names."""
    return (*rule.sender, *rule.receiver)


def _sight(robot: int, actor: Actor | None, fleet: Collection[int], *, moving: bool) -> Sight:
    if actor is None:
        return Sight(robot, "gone", drives=moving)
    core = actor.core
    return Sight(
        robot,
        _state_of(core),
        core.fence.key,
        _role_of(core),
        moving,
        _named(core.fence, fleet),
        core.reported | {link.neighbour for link in core.links},
        [link.neighbour for link in core.links if link.silent],
    )


def _state_of(core: Robot) -> str:
    return core.state.value if core.awake else "waking"


def _role_of(core: Robot) -> str:
    """Its part in the view and in the strand."""
    place = ""
    if core.state is State.MEMBER:
        place = "leader" if core.leads else "middle" if len(core.links) == 2 else "tail"
    return f"{place} coordinator".strip() if core.coordinates else place


def _named(fence: Fence, fleet: Collection[int]) -> Collection[int]:
    """The robots that may move by this fence."""
    match fence.may:
        case May.ONE:
            return (fence.robot,)
        case May.ALL:
            return fleet
        case May.NOBODY | May.STOPPED:
            return ()
        case _:
            assert_never(fence.may)
