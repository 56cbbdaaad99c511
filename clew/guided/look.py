"""Looks at a rehearsal for its cells: the fence, the states of its robots, and the faults in progress."""

from collections.abc import Iterator, Sequence

from agents.membership.states import State
from agents.robot import Robot
from clew.guided.cells import TURNS_MAX, Cell, Seen, View, cells
from clew.rehearsal.actor import Actor
from clew.rehearsal.rehearsal import Rehearsal
from protocol.faults.plan import Plan
from protocol.faults.rules import ROUTER, MessageRule, Partition
from protocol.fence import Fence, May
from protocol.keys import WORLD, robot_name


def look(rehearsal: Rehearsal) -> set[Cell]:
    """The cells that the rehearsal is in now."""
    actors, fence = rehearsal.processes.actors, rehearsal.world.arena.fence
    moving, faults = rehearsal.world.bodies.moving.tolist(), _Faults(rehearsal)
    fleet = [
        _seen(actors.get(robot), fence, robot, faults.of(robot), drives=drives)
        for robot, drives in enumerate(moving, start=1)
    ]
    coordinator = actors.get(fence.epoch.robot)
    phase = "" if coordinator is None or coordinator.core.phase is None else coordinator.core.phase
    return set(cells(View(fence.may, phase, min(fence.turn, TURNS_MAX)), fleet))


def in_focus(rehearsal: Rehearsal) -> Sequence[int]:
    """The robots on which most depends now: the view's coordinator; any, where there is none."""
    coordinator = rehearsal.world.arena.fence.epoch.robot
    return [coordinator] if coordinator else range(1, len(rehearsal.world.bodies.moving) + 1)


class _Faults:
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
        if any(name in (*rule.group, *rule.others) for rule in self._cuts):
            return "cut"
        if actor is not None and actor.delay_s > 0.0:
            return "slow"
        struck = [rule for rule in self._others if name in _limits(rule) or _limits(rule) <= {WORLD, ROUTER}]
        return struck[0].fault if struck else ""


def message_rules(plan: Plan) -> Iterator[MessageRule]:
    """The rules of the plan for messages."""
    return (rule for rule in plan.rules if isinstance(rule, MessageRule))


def _limits(rule: MessageRule) -> set[str]:
    """The processes that the rule names."""
    return {*rule.sender, *rule.receiver}


def _seen(actor: Actor | None, fence: Fence, robot: int, trouble: str, *, drives: bool) -> Seen:
    named = fence.may is May.ONE and fence.robot == robot
    if actor is None:
        return Seen("gone", "", drives, "", named, trouble, 0)
    core = actor.core
    behind = "" if core.fence == fence else "turn" if core.fence.epoch == fence.epoch else "epoch"
    silent = sum(link.silent for link in core.links)
    state = core.state.value if core.awake else "waking"
    return Seen(state, _role_of(core), drives, behind, named, trouble, silent)


def _role_of(core: Robot) -> str:
    """Its part in the view and in the strand."""
    place = ""
    if core.state is State.MEMBER:
        place = "leader" if core.leads else "middle" if len(core.links) == 2 else "tail"
    return f"{place} coordinator".strip() if core.coordinates else place
