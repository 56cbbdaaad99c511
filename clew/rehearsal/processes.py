"""The processes of a rehearsal: which are alive, frozen, slow or cut off, and how process faults change that.

Rule 1: while the world's process is down, bodies move and time goes on, but it sends and receives nothing.
        Its successor has its state, which a live one restores from the timeline.
Rule 2: while the router is down, all messages are lost. When it is back, all tokens are back at once.
Rule 3: a thaw has no effect on a process that is not frozen: one that was killed stays away until its start.
"""

from collections import Counter
from collections.abc import Callable

from agents.process.journal import Head, Journal
from agents.process.watching import watched_by
from agents.robot import Robot
from clew.rehearsal.actor import Actor, Desk
from clew.rehearsal.tokens import Tokens
from protocol.errors import UsageError
from protocol.faults.fit import called, check_fits
from protocol.faults.message_faults import MessageFaults
from protocol.faults.plan import Plan
from protocol.faults.process_faults import ProcessAction, ProcessFault
from protocol.faults.rules import ROUTER, Slow
from protocol.fence import LIFE_BITS
from protocol.keys import WORLD, WORLD_NUMBER, robot_name, robot_number
from protocol.laws import find
from protocol.mission import Mission
from world.chance import stream

Journals = Callable[[Head], Journal]
"""What opens the journal of a robot's process."""


def no_journal(_: Head) -> Journal:
    """Open a journal that writes nothing."""
    return Journal()


class Processes:
    """All processes by number: robots from 1, the world is 0."""

    def __init__(self, mission: Mission, seed: int, journals: Journals = no_journal) -> None:
        self.actors: dict[int, Actor] = {}
        """The live processes of robots."""
        self.desk = Desk(WORLD)
        self.router_is_up = True
        self.tokens = Tokens()
        self._mission = mission
        self._journals = journals
        self._seed = seed
        self._lives: Counter[int] = Counter()
        self._frozen: set[str] = set()
        """Of the world and the router, which are frozen (rule 3)."""
        self._show(WORLD_NUMBER)

    def start(self, robot: int) -> Actor:
        """Start a robot's process. It has no memory and does not know the time."""
        incarnation = self._show(robot)
        again = self._lives[robot] > 1
        life = self._draw_life(robot)
        head = Head(robot=robot, incarnation=incarnation, mission=self._mission, life=life, again=again)
        journal = self._journals(head)
        core = Robot(robot, self._mission, life=life, again=again)
        actor = Actor(robot, robot_name(robot), incarnation, core, journal)
        self.actors[robot] = actor
        self.tokens.watch(robot, watched_by(robot, actor.wanted))
        return actor

    def end(self, robot: int) -> None:
        """End a robot's process; its body stays."""
        actor = self.actors.pop(robot)
        actor.end()
        actor.journal.close()
        self.tokens.end(robot)

    def find(self, process: int) -> Actor | Desk | None:
        """The process with this number, or None."""
        return self.desk if process == WORLD_NUMBER else self.actors.get(process)

    def inject(self, fault: ProcessFault, now_s: float) -> Actor | None:
        """Inject a process fault; returns the robot that it has started, if any."""
        if (robot := robot_number(fault.process)) is None:
            self._inject_shared(fault, now_s)
        elif (actor := self.actors.get(robot)) is not None:
            self._inject_robot(actor, fault, now_s)
        elif fault.action is ProcessAction.START:
            return self.start(robot)
        return None

    def cut_off(self, faults: MessageFaults, *, now_s: float, step: int) -> set[int]:
        """The processes that are cut off from the router."""
        if not self.router_is_up:
            return {WORLD_NUMBER, *self.actors}
        if not faults.may_cut:
            return set()
        names = {WORLD: WORLD_NUMBER} | {actor.name: actor.robot for actor in self.actors.values()}
        return {names[name] for name in faults.cut_off(names, now_s=now_s, step=step)}

    def _inject_shared(self, fault: ProcessFault, now_s: float) -> None:
        """Inject a fault of the router or the world."""
        if fault.action is ProcessAction.THAW and fault.process not in self._frozen:
            return
        self._frozen.discard(fault.process)
        if fault.action is ProcessAction.FREEZE:
            self._frozen.add(fault.process)
        if fault.process == ROUTER:
            self.router_is_up = fault.action in {ProcessAction.START, ProcessAction.THAW}
        else:
            self._inject_world(fault.action, now_s)

    def _inject_world(self, action: ProcessAction, now_s: float) -> None:
        match action:
            case ProcessAction.KILL:
                self.desk.end()
                self.tokens.end(WORLD_NUMBER)
            case ProcessAction.FREEZE:
                self.desk.end()
                self.tokens.freeze(WORLD_NUMBER, now_s)
            case ProcessAction.START:
                self.desk = Desk(WORLD, self.desk.traffic)
                self._show(WORLD_NUMBER)
            case ProcessAction.THAW:
                self.desk = Desk(WORLD, self.desk.traffic)
                self.tokens.thaw(WORLD_NUMBER)
                self.tokens.forget(WORLD_NUMBER)
            case ProcessAction.SLOW | ProcessAction.UNSLOW:
                pass  # `check_rehearsable` refuses it

    def _inject_robot(self, actor: Actor, fault: ProcessFault, now_s: float) -> None:
        match fault.action:
            case ProcessAction.KILL:
                self.end(actor.robot)
            case ProcessAction.FREEZE:
                actor.freeze()
                self.tokens.freeze(actor.robot, now_s)
            case ProcessAction.THAW:
                actor.thaw()
                self.tokens.thaw(actor.robot)
            case ProcessAction.SLOW | ProcessAction.UNSLOW:
                actor.slow_down(fault.delay_s)
            case ProcessAction.START:
                pass  # it is alive already

    def _draw_life(self, robot: int) -> int:
        """The random bits of a process, from the seed, the robot and the count of its starts."""
        drawn = stream(self._seed, f"life/{robot}/{self._lives[robot]}")
        return int(drawn.integers(2**LIFE_BITS)) | 1  # never 0, which is of no robot

    def _show(self, process: int) -> str:
        """Show the token of a new process; returns its incarnation."""
        self._lives[process] += 1
        self.tokens.show(process, incarnation := str(self._lives[process]))
        return incarnation


def check_rehearsable(plan: Plan, mission: Mission, source: str | None = None) -> None:
    """Refuse a plan that does not fit the fleet or needs a live run, and a law that is not here.

    Args:
        plan: the plan.
        mission: the fleet's.
        source: names the plan in error messages, as its user did.

    Raises:
        UsageError: the message names the rule, or the law.
    """
    find(mission.law)
    check_fits(plan, robots=mission.robots, source=source)
    for rule in plan.rules:
        if isinstance(rule, Slow) and rule.target == WORLD:
            raise UsageError(
                f"{called(plan, source)}: {rule.name} slows the world, which only a live run can do"
            )
