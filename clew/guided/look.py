"""Looks at a rehearsal for its cells: the states of its robots, and the faults in progress."""

from collections.abc import Collection, Iterator, Sequence
from dataclasses import dataclass

from agents.robot import Robot
from clew.guided.cells import Cell, cells
from clew.rehearsal.actor import Actor
from clew.rehearsal.rehearsal import Rehearsal
from protocol.faults.plan import Plan
from protocol.faults.rules import ROUTER, MessageRule, Partition
from protocol.keys import WORLD, robot_name


@dataclass(frozen=True, slots=True)
class Sight:
    """A robot, as a cell needs it."""

    robot: int
    state: str
    epoch: int = -1
    role: str = ""
    drives: bool = False
    bound: Collection[int] = ()
    silent: Collection[int] = ()


def look(rehearsal: Rehearsal) -> set[Cell]:
    """The cells that the rehearsal is in now."""
    fleet = range(1, rehearsal.world.scenario.fleet.robots + 1)
    actors = rehearsal.processes.actors
    moving = rehearsal.world.bodies.moving
    sights = [_sight(robot, actors.get(robot), moving=bool(moving[robot - 1])) for robot in fleet]
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


def _sight(robot: int, actor: Actor | None, *, moving: bool) -> Sight:
    if actor is None:
        return Sight(robot, "gone", drives=moving)
    state, role, bound, silent = _state_of(actor.core)
    return Sight(robot, state, actor.core.epoch, role, moving, bound, silent)


def _state_of(core: Robot) -> tuple[str, str, Collection[int], Collection[int]]:
    """State, role, who is with it, and whom it does not hear."""
    member, lining = core._member, core._lining
    if member is not None:
        strand = member.strand
        role = "leader" if strand.ahead is None else "tail" if strand.behind is None else "middle"
        silent = [link.neighbour for link in strand.links if link.silent]
        state = "dissolving" if member.dissolves else "turning" if strand.reversal else "member"
        return state, role, strand.order, silent
    if lining is None:
        return "aside" if core._driver.awake else "waking", "", (), ()
    state = "bound" if lining.all_are_bound else "called" if lining.is_called else "lining"
    return state, "", lining.members, ()
