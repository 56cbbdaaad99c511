"""The rehearsal: a whole fleet and its world in one process, in virtual time, fully determined by one seed.

Rule 1: the cores are those of a live run. Only the network differs (`clew.rehearsal.exchange`), and the
        timeline needs no outbox, since no entry is lost.
Rule 2: the work of a live shell beside the core (newest odometry, phases, message counts) is done here as
        well (docs/run.md).
Rule 3: nothing depends on the wall clock, on process ids, or on the order of a set.
Rule 4: the user's request to end is obeyed before each event that a robot would handle: with hundreds of
        robots a tick takes seconds.
Rule 5: process faults are injected at the beginning of a tick, except for those at a point of a step.
"""

from collections.abc import Callable, Iterator, Sequence

from agents.commands import AskScan, Order, Put, Say, Tell
from agents.commands import Command as RobotCommand
from agents.commands import Note as RobotNote
from agents.events import Event as RobotEvent
from agents.events import OdometryHeard
from agents.process import addresses
from agents.process.failure import failed
from agents.process.journal import Given, decided
from agents.process.points import is_plan
from agents.process.watching import watched_by
from clew.rehearsal.actor import Actor, Arrival, Desk
from clew.rehearsal.exchange import Exchange
from clew.rehearsal.logbook import Logbook
from clew.rehearsal.mail import Mail, event_for_robot, event_for_world
from clew.rehearsal.processes import Journals, Processes, check_rehearsable, no_journal
from clew.rehearsal.token_events import TokenEvent, key_of, to_robot, to_world
from clew.rehearsal.tokens import Seen
from protocol.errors import MessageRefusedError
from protocol.exit_codes import ExitCode
from protocol.faults.plan import NO_FAULTS, Plan
from protocol.faults.process_faults import ProcessAction, ProcessFault, ProcessFaults
from protocol.faults.rules import ROUTER, StepPoint
from protocol.keys import WORLD, WORLD_NUMBER
from protocol.timeline import Entry, MessageRefused, Record, RobotSettled, RobotStarted, TrafficCounted
from protocol.wire.messages import Message, Phase, ScanQuery
from world.commands import Command as WorldCommand
from world.commands import Note, ServeScan, TellOdometry
from world.core import World
from world.events import EntryRead, EntryWritten, MessageDropped, StopAsked
from world.events import Event as WorldEvent
from world.scenario.scenario import Scenario

Asked = Callable[[], ExitCode | None]
NO_PROCESS = 0  # the process id of a robot without a process of its own


def nobody_asks() -> None:
    """Let a run come to its own end."""


class Rehearsal:
    """One rehearsed run, tick by tick.

    Raises:
        UsageError: the fault plan does not fit the fleet, or only a live run can execute it.
    """

    def __init__(
        self, scenario: Scenario, seed: int, plan: Plan = NO_FAULTS, *, journals: Journals = no_journal
    ) -> None:
        check_rehearsable(plan, scenario.mission())
        self.world = World(scenario, seed=seed, wall_s=0.0)
        self._seed = seed
        self.plan = plan
        self._exchange = Exchange(plan, seed)
        self._process_faults = ProcessFaults(plan, seed)
        self._processes = Processes(scenario.mission(), seed, journals)
        self._logbook = Logbook()
        self._asked: Asked = nobody_asks
        self._stopped = False
        for robot in range(1, scenario.fleet.robots + 1):
            self._begin(self._processes.start(robot))

    @property
    def entries(self) -> list[tuple[str, Entry]]:
        """The timeline: pairs of source and entry."""
        return self._logbook.entries

    @property
    def processes(self) -> Processes:
        """The processes, to look at."""
        return self._processes

    @property
    def account(self) -> TrafficCounted:
        """The message counts of the world's own process."""
        return self._processes.desk.traffic.counted()

    def run(self) -> "Rehearsal":
        """Run until the run has been judged."""
        for _ in self.ticks():
            pass
        return self

    def ticks(self, asked: Asked = nobody_asks) -> Iterator[float]:
        """Run tick by tick until the run has been judged; yields the time after each tick.

        Args:
            asked: whether the user has asked the run to end (rule 4).
        """
        self._asked = asked
        network = self._exchange.network
        while self.world.judgement is None:
            now_s = self.world.now_s
            router = ROUTER if self._inject_due(now_s) else None
            self._execute_world(self.world.look(wall_s=now_s, router=router))
            while (due := network.next_due(now_s)) is not None:
                self._deliver(*due)
            self._execute_world(self.world.tick())
            self._is_asked_to_end()
            yield self.world.now_s

    def turn_to(self, plan: Plan) -> None:
        """Use this plan from now on, for all faults. What the old plan has begun goes on.

        Messages in transit are not affected.
        """
        self.plan = plan
        self._exchange.use(self._exchange.message_faults.turned_to(plan))
        self._process_faults.turn_to(plan)

    def close(self) -> None:
        """Close the journals of the processes that are still alive."""
        for actor in self._processes.actors.values():
            actor.journal.close()

    def stop(self, exit_code: ExitCode) -> None:
        """End the run as the user would with a signal. Robots handle nothing more (rule 4)."""
        self._stopped = True
        self._tell_world(StopAsked(exit_code))

    def _is_asked_to_end(self) -> bool:
        """Obey a request to end, and say whether there has been one (rule 4)."""
        if not self._stopped and (exit_code := self._asked()) is not None:
            self.stop(exit_code)
        return self._stopped

    # --- process faults and tokens ------------------------------------------------------------------

    def _inject_due(self, now_s: float) -> bool:
        """Inject the process faults that are due; returns whether the world is connected to the router."""
        for fault in self._process_faults.due(now_s):
            self._inject(fault)
        processes = self._processes
        cut = processes.cut_off(self._exchange.message_faults, now_s=now_s, step=self._process_faults.step)
        processes.tokens.cut(cut, now_s)
        for seen in processes.tokens.changes(now_s):
            self._show(seen)
        for actor in [actor for actor in processes.actors.values() if actor.is_behind]:
            if actor.attends(now_s):
                self._wake(actor)
        return WORLD_NUMBER not in cut

    def _inject(self, fault: ProcessFault) -> None:
        self._write(WORLD, self.world.now_s, fault.as_record())
        was_down = self._processes.desk.ended
        started = self._processes.inject(fault, self.world.now_s)
        if was_down and not self._processes.desk.ended:
            self._come_back(fault.action)
        if started is not None:
            self._begin(started)

    def _come_back(self, action: ProcessAction) -> None:
        """The world's process runs again; one that was killed has raised the fence."""
        now_s = self.world.now_s
        if action is ProcessAction.START:
            self._execute_world(self.world.restart(wall_s=now_s))
        else:
            self.world.come_back(wall_s=now_s)

    def _begin(self, actor: Actor) -> None:
        self._logbook.begin(actor.name)
        started = RobotStarted(pid=NO_PROCESS, incarnation=actor.incarnation)
        self._write(actor.name, actor.come_s, started)

    def _show(self, seen: Seen) -> None:
        observer = self._processes.find(seen.observer)
        if isinstance(observer, Desk) and not observer.ended:
            for event in to_world(seen):
                self._tell_world(event)
        elif isinstance(observer, Actor):
            self._give(observer, to_robot(seen))

    def _give(self, actor: Actor, item: Arrival | RobotEvent) -> None:
        if actor.attends(self.world.now_s):
            self._handle_batch(actor, [item])
        else:
            actor.wait(item)

    # --- mail ---------------------------------------------------------------------------------------

    def _send(self, sender: int, receiver: int, key: str, number: int, message: Message) -> None:
        processes, now_s = self._processes, self.world.now_s
        to = processes.find(receiver)
        if to is None:
            return
        mail = Mail(sender, receiver, key, number, message)
        if not processes.router_is_up:
            self._exchange.lose(mail, to, ROUTER)
        elif to.ended:
            self._exchange.lose(mail, to, to.name)
        elif isinstance(to, Actor) and not to.attends(now_s):
            to.wait(mail)
        else:
            for delay_s, arrival in self._open(mail, to):
                self._exchange.network.send((to, arrival), now_s + delay_s)

    def _open(self, mail: Mail, to: Actor | Desk) -> tuple[tuple[float, Arrival], ...]:
        if isinstance(to, Actor):
            to.meet(mail.message)
            now_s = to.come_s
        else:
            now_s = self.world.now_s
        opened = self._exchange.open(mail, to, now_s=now_s, step=self._process_faults.step)
        for record in opened.records:
            self._write_for(to, record)
        return opened.arrivals

    def _deliver(self, to: Actor | Desk, arrival: Arrival) -> None:
        if to.ended:
            return
        if isinstance(to, Actor):
            self._give(to, arrival)
        elif (mail := self._undamaged(to, arrival)) is not None and (
            event := event_for_world(mail.message, mail.sender)
        ) is not None:
            self._tell_world(event)

    def _undamaged(self, to: Actor | Desk, arrival: Arrival) -> Mail | None:
        """The mail as decoded; None where the codec refuses it."""
        if arrival.damage is None:
            return arrival.mail
        try:
            return arrival.mail.damaged(arrival.damage)
        except MessageRefusedError as error:
            key, reason = arrival.mail.key, str(error)
            to.traffic.refuse(key)
            if isinstance(to, Desk):
                self._tell_world(MessageDropped(key, reason))
            else:
                self._write(to.name, to.come_s, MessageRefused(key=key, reason=reason))
            return None

    # --- robots -------------------------------------------------------------------------------------

    def _wake(self, actor: Actor) -> None:
        """Let it go on: first its unfinished commands, then all waiting items at once."""
        for command in actor.take_unfinished():
            self._execute_robot(actor, command)
        items: list[Arrival | RobotEvent | Given] = []
        for item in actor.take_waiting():
            if not isinstance(item, Mail):
                items.append(item)
                continue
            for delay_s, arrival in self._open(item, actor):
                if delay_s == 0.0:
                    items.append(arrival)
                else:
                    self._exchange.network.send((actor, arrival), self.world.now_s + delay_s)
        self._handle_batch(actor, items)

    def _handle_batch(self, actor: Actor, items: Sequence[Arrival | RobotEvent | Given]) -> None:
        """Handle items that arrived together, in order. Only the newest odometry counts; it sets the time."""
        actor.begin_batch(self.world.now_s)
        before, all_given = actor.phase, [given for item in items if (given := self._read(actor, item))]
        for given in all_given:
            if isinstance(given.event, OdometryHeard):
                actor.hear_world(given.event.odometry)
        if actor.phase is Phase.RUNNING:
            self._react_to_all(actor, [given for given in all_given if not actor.is_outdated(given.event)])
            self._watch(actor)
        elif actor.phase is not before:
            self._close(actor, before)

    def _react_to_all(self, actor: Actor, all_given: Sequence[Given]) -> None:
        """React to each input. If the robot is frozen by one, the rest waits until it thaws."""
        for place, given in enumerate(all_given, start=1):
            self._react(actor, given)
            if actor.ended:
                return
            if actor.frozen:
                for rest in all_given[place:]:
                    actor.wait(rest)
                return

    def _watch(self, actor: Actor) -> None:
        """Watch the tokens that its core wants to be watched; they are seen in the next tick."""
        wanted = actor.core.watches
        if wanted != actor.wanted and not (actor.ended or actor.frozen):
            actor.want(wanted)
            self._processes.tokens.watch(actor.robot, watched_by(actor.robot, wanted))

    def _read(self, actor: Actor, item: Arrival | RobotEvent | Given) -> Given | None:
        if isinstance(item, Arrival):
            mail = self._undamaged(actor, item)
            event = None if mail is None else event_for_robot(mail.message, mail.sender, mail.number)
            return None if mail is None or event is None else Given(event, mail.key, mail.number)
        if isinstance(item, TokenEvent):
            return Given(item, key_of(item), 0)
        return item if isinstance(item, Given) else None  # no other event arrives by itself

    def _react(self, actor: Actor, given: Given) -> None:
        """Let the robot decide and execute its commands, unless a fault hits a point of its step."""
        if self._is_asked_to_end():
            return
        event = given.event
        try:
            commands = decided(actor.core, given, actor.now_s, actor.journal)
        except Exception as error:  # as in a live run: record it, and end the process
            self._write(actor.name, actor.come_s, failed(error))
            self._processes.end(actor.robot)
            return
        if self._process_faults.has_points:
            commands = self._pass_points(actor, event, commands)
        for command in commands:
            self._execute_robot(actor, command)

    def _pass_points(
        self, actor: Actor, event: RobotEvent, commands: list[RobotCommand]
    ) -> list[RobotCommand]:
        """Pass the points of its step in turn; returns the commands that are still to be executed now."""
        points = actor.points.passed(event, commands)
        scans = [point for point in points if point is StepPoint.AFTER_SCAN]
        if self._is_stopped(actor, scans, commands):
            return []
        for command in filter(is_plan, commands):
            self._execute_robot(actor, command)
        others = [point for point in points if point is not StepPoint.AFTER_SCAN]
        rest = [command for command in commands if not is_plan(command)]
        return [] if self._is_stopped(actor, others, rest) else rest

    def _is_stopped(self, actor: Actor, points: Sequence[StepPoint], rest: Sequence[RobotCommand]) -> bool:
        """Whether a fault at these points ends or freezes it. A frozen robot keeps the rest for later."""
        for fault in self._process_faults.at_points(actor.name, points, self.world.now_s):
            self._inject(fault)
        actor.leave_unfinished(rest if actor.frozen else ())
        return actor.ended or actor.frozen

    def _close(self, actor: Actor, before: Phase) -> None:
        """Record the counts of sent messages; when all robots have, record the received ones and end."""
        if before is Phase.RUNNING:
            actor.journal.end("the run is over")
            self._write(actor.name, actor.come_s, RobotSettled(sent=dict(actor.traffic.sent)))
        if actor.phase is Phase.CLOSING:
            self._write(actor.name, actor.come_s, actor.traffic.counted())
            self._processes.end(actor.robot)

    def _execute_robot(self, actor: Actor, command: RobotCommand) -> None:
        robot = actor.robot
        match command:
            case Say() | Tell() | Put() | Order():
                receiver, key, message = addresses.addressed(robot, command)
                self._send(robot, receiver, key, actor.traffic.send(key), message)
            case AskScan(revolutions):
                query = ScanQuery(revolutions=revolutions)
                self._send(robot, WORLD_NUMBER, addresses.scan(robot), 0, query)
            case RobotNote(record):
                self._write(actor.name, actor.come_s, record)

    # --- the world ----------------------------------------------------------------------------------

    def _tell_world(self, event: WorldEvent) -> None:
        self._execute_world(self.world.handle(event, wall_s=self.world.now_s))

    def _execute_world(self, commands: list[WorldCommand]) -> None:
        for command in commands:
            match command:
                case Note(t_s, record):
                    self._write(WORLD, t_s, record)
                case _ if self._processes.desk.ended:
                    pass  # the bodies move on, but nothing is sent
                case TellOdometry(robot, odometry):
                    key = addresses.odometry(robot)
                    self._send(WORLD_NUMBER, robot, key, self._processes.desk.traffic.send(key), odometry)
                case ServeScan(robot, scan):
                    self._send(WORLD_NUMBER, robot, addresses.scan(robot), 0, scan)

    # --- the timeline -------------------------------------------------------------------------------

    def _write_for(self, party: Actor | Desk, record: Record) -> None:
        self._write(party.name, self.world.now_s if isinstance(party, Desk) else party.come_s, record)

    def _write(self, source: str, t_s: float, record: Record) -> None:
        entry = self._logbook.write(source, t_s, record)
        self._process_faults.hear(source, entry)
        now_s = self.world.now_s
        self.world.handle(EntryWritten(source, entry), wall_s=now_s)
        self.world.handle(EntryRead(source, entry), wall_s=now_s)
