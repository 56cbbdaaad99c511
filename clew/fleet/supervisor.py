"""Supervises the processes of one run: events in, commands out. Pure: no process, no clock, no file.

Rule 1: the world's end is the end of the run, and its exit code is ours.
Rule 2: a router that ends is started again, and so is a world that a signal has killed: it goes on from its
        timeline. Both have a limit. A host that fails before the world ends the run with exit code 1.
Rule 3: SIGINT, SIGTERM and SIGHUP end the run with 130, 143 and 129.
Rule 4: viewer and table only read the world's files. The run continues without them; they end with it.
Rule 5: a part that a process fault has killed is restarted; a frozen one is thawed, at the latest at the end.

`rules.py` says what is done in which state, `facts.py` what an event means, `ending.py` how a run ends.
"""

import signal
from collections.abc import Callable, Iterator, Mapping

from clew.fleet.supervision.ending import Ending
from clew.fleet.supervision.events import (
    HOST,
    TABLE,
    VIEWER,
    WORLD,
    Activate,
    Command,
    Event,
    Exit,
    MendTerminal,
    Publish,
    Say,
    Signal,
    Start,
    Tick,
    router_name,
)
from clew.fleet.supervision.facts import Facts, Happening, end_of
from clew.fleet.supervision.limits import Limits, Plan
from clew.fleet.supervision.rules import TABLE as RULE_FOR
from clew.fleet.supervision.rules import Do, State, What
from protocol.exit_codes import ExitCode
from protocol.faults.process_faults import ProcessAction
from protocol.process.asked import signal_of
from protocol.process.ending import FAIL


class Supervisor:
    """Decides about the processes of one run."""

    def __init__(self, plan: Plan, limits: Limits | None = None) -> None:
        self.state = State.ROUTERS
        self._plan, self._limits = plan, limits or Limits()
        self._facts = Facts(self._limits)
        self._deadline_s: float | None = None
        self._away_s: dict[str, float] = {}
        """How long a part that a process fault is killing stays down."""
        self._ending = Ending(self._facts)
        self._lost: Happening | None = None
        """The part that the run has lost, and the user has not been told of."""

    def wake_at(self) -> float | None:
        """The time of the next `Tick`."""
        times_s = (self._deadline_s, self._facts.next_timer_s())
        return min((at_s for at_s in times_s if at_s is not None), default=None)

    def handle(self, event: Event, now_s: float) -> list[Command]:
        """The commands for an event, in order."""
        commands: list[Command] = []
        for happening in self._facts.take(event, now_s):
            commands += self._obey(happening, now_s)
        if event == Tick() and self._deadline_s is not None and now_s >= self._deadline_s:
            commands += self._obey(Happening(What.TIME_UP), now_s)
        while (what := self._follows()) is not None:
            commands += self._obey(Happening(what), now_s)
        return commands

    def _obey(self, happening: Happening, now_s: float) -> Iterator[Command]:
        rule = RULE_FOR[self.state, happening.what]
        yield from ACTIONS[rule.do](self, happening, now_s)
        if rule.to is not None:
            self.state, self._deadline_s = rule.to, self._deadline_of(rule.to, now_s)

    def _deadline_of(self, state: State, now_s: float) -> float | None:
        limits = self._limits
        match state:
            case State.ROUTERS | State.PAGE:
                return now_s + (limits.ready_s if state is State.ROUTERS else limits.page_s)
            case State.GIVING_UP:
                return now_s + limits.grace_s
            case State.ASKING_WORLD:
                return min(now_s + limits.world_s, self._ending.since_s + limits.world_by_s)
            case State.ASKING_ALL:
                return now_s + limits.others_s
            case State.KILLING:
                return now_s + limits.killed_s
            case State.RUNNING | State.OVER:
                return None

    def _follows(self) -> What | None:
        """The happenings that follow from the known facts without another event."""
        facts = self._facts
        match self.state:
            case State.ROUTERS if len(facts.listening) >= self._plan.routers:
                return What.ALL_LISTEN
            case State.PAGE if facts.page_is_up or not facts.is_running(VIEWER):
                return What.PAGE_SETTLED
            case State.GIVING_UP | State.ASKING_WORLD if not facts.is_there(WORLD):
                return What.WORLD_GONE
            case State.ASKING_ALL | State.KILLING if not facts.present():
                return What.ALL_GONE
            case _:
                return None

    # The start of a run.

    def _begin(self, _: Happening, now_s: float) -> Iterator[Command]:
        if self._plan.view:
            yield self._start(VIEWER)
        if self._plan.routers > 0:
            yield Activate(router_name(self._facts.active))
        yield from self._start_router(_, now_s)

    def _start_router(self, _: Happening, now_s: float) -> Iterator[Command]:
        number = len(self._facts.listening) + 1
        if number <= self._plan.routers:
            yield self._start(router_name(number))
            self._deadline_s = self._deadline_of(self.state, now_s)  # each has its own

    def _say_page(self, happening: Happening, _: float) -> Iterator[Command]:
        yield Say(f"the page is at {happening.said}")

    def _start_fleet(self, _: Happening, _now_s: float) -> Iterator[Command]:
        yield self._start(WORLD)
        if self._plan.table:
            yield self._start(TABLE)
        yield self._start(HOST)
        yield Publish()

    def _start(self, part: str, *, resume: bool = False) -> Start:
        self._facts.started(part)
        return Start(part, resume)

    # Parts that are lost and restarted.

    def _restart_router(self, happening: Happening, now_s: float) -> Iterator[Command]:
        yield Say(f"{end_of(happening)}; it is started again")
        if self._plan.routers > 1 and happening.part == router_name(self._facts.active):
            self._facts.activate(3 - self._facts.active)  # 1 or 2
            yield Activate(router_name(self._facts.active))
        yield from self._replace(happening.part, now_s)

    def _restart_world(self, happening: Happening, now_s: float) -> Iterator[Command]:
        yield Say(f"{end_of(happening)}; it is started again")
        yield from self._replace(WORLD, now_s)

    def _replace(self, part: str, now_s: float) -> Iterator[Command]:
        away_s = self._away_s.pop(part, None)
        if away_s is None:
            yield self._start(part, resume=part == WORLD)
        else:
            self._facts.set_timer(What.RESTART_DUE, part, now_s + away_s)

    def _start_again(self, happening: Happening, _: float) -> Iterator[Command]:
        yield self._start(happening.part, resume=happening.part == WORLD)

    def _say_reader_ended(self, happening: Happening, _: float) -> Iterator[Command]:
        if happening.part == TABLE:
            yield MendTerminal()
        yield Say(f"{end_of(happening)}; the run goes on")

    # Process faults.

    def _inject(self, happening: Happening, now_s: float) -> Iterator[Command]:
        part, fault = happening.part, happening.fault
        assert fault is not None
        match fault.action:
            case ProcessAction.KILL:
                if fault.wall_s is not None:
                    self._away_s[part] = fault.wall_s
                yield Signal(part, signal.SIGKILL)
            case ProcessAction.FREEZE:
                self._facts.froze(part)
                if fault.wall_s is not None:
                    self._facts.set_timer(What.THAW_DUE, part, now_s + fault.wall_s)
                yield Signal(part, signal.SIGSTOP)
            case ProcessAction.THAW:
                yield from self._thaw(happening, now_s)
            case ProcessAction.START | ProcessAction.SLOW | ProcessAction.UNSLOW:
                pass  # a killed part is restarted anyway; a slow world notices it by itself

    def _thaw(self, happening: Happening, _: float) -> Iterator[Command]:
        self._facts.thawed(happening.part)
        yield Signal(happening.part, signal.SIGCONT)

    # The reasons why a run ends.

    def _give_up(self, happening: Happening, now_s: float) -> Iterator[Command]:
        self._lost = happening
        if happening.part != HOST or happening.status < 0:
            yield from self._say_lost()
        self._ending.begin(now_s)  # a host that has reaped all robots: the world may be about to end, too

    def _say_lost(self) -> Iterator[Command]:
        if self._lost is not None:
            late = "before the world" if self._lost.part == HOST else "once too often"
            yield Say(f"{end_of(self._lost)} {late}")
        self._lost = None

    def _end_unready(self, happening: Happening, now_s: float) -> Iterator[Command]:
        if happening.what is What.TIME_UP:
            yield Say(f"the router is not ready after {self._limits.ready_s:g} s")
        else:
            yield Say(f"{end_of(happening)} before it was ready")
        yield from self._ending.ask_world(ExitCode.FAILED, now_s)

    def _end_refused(self, _: Happening, now_s: float) -> Iterator[Command]:
        yield from self._ending.ask_world(ExitCode.USAGE, now_s)

    def _end_with_world(self, happening: Happening, now_s: float) -> Iterator[Command]:
        code = happening.status if happening.status >= 0 else 128 - happening.status
        if self._facts.verdict_code is None:
            yield Say(end_of(happening))
        elif happening.status < 0:
            code = self._facts.verdict_code  # killed right after it had written that
        # The request was checked before. So with our own router, it is the run that failed.
        failed = code == ExitCode.USAGE and self._plan.routers > 0
        yield from self._ending.ask_world(ExitCode.FAILED if failed else code, now_s)

    def _end_as_asked(self, happening: Happening, now_s: float) -> Iterator[Command]:
        number = signal_of(happening.status) or signal.SIGTERM  # the verdict says which it was
        yield from self._ending.ask_world(happening.status, now_s, number)

    def _end_failed(self, _: Happening, now_s: float) -> Iterator[Command]:
        yield from self._say_lost()
        yield from self._ending.ask_world(ExitCode.FAILED, now_s, FAIL)

    # The end of a run.

    def _ask_all(self, _: Happening, now_s: float) -> Iterator[Command]:
        yield from self._ending.ask_all(now_s)

    def _kill(self, _: Happening, now_s: float) -> Iterator[Command]:
        yield from self._ending.kill(now_s)

    def _exit(self, _: Happening, _now_s: float) -> Iterator[Command]:
        yield Exit(self._ending.code)

    def _nothing(self, _: Happening, _now_s: float) -> Iterator[Command]:
        yield from ()


ACTIONS: Mapping[Do, Callable[[Supervisor, Happening, float], Iterator[Command]]] = {
    Do.BEGIN: Supervisor._begin,
    Do.START_ROUTER: Supervisor._start_router,
    Do.SAY_PAGE: Supervisor._say_page,
    Do.START_FLEET: Supervisor._start_fleet,
    Do.RESTART_ROUTER: Supervisor._restart_router,
    Do.RESTART_WORLD: Supervisor._restart_world,
    Do.START_AGAIN: Supervisor._start_again,
    Do.SAY_READER_ENDED: Supervisor._say_reader_ended,
    Do.INJECT: Supervisor._inject,
    Do.THAW: Supervisor._thaw,
    Do.GIVE_UP: Supervisor._give_up,
    Do.END_UNREADY: Supervisor._end_unready,
    Do.END_REFUSED: Supervisor._end_refused,
    Do.END_WITH_WORLD: Supervisor._end_with_world,
    Do.END_AS_ASKED: Supervisor._end_as_asked,
    Do.END_FAILED: Supervisor._end_failed,
    Do.ASK_ALL: Supervisor._ask_all,
    Do.KILL: Supervisor._kill,
    Do.EXIT: Supervisor._exit,
    Do.NOTHING: Supervisor._nothing,
}
