"""The core of the world of one run: robots present, messages to them, end of the run. No clock, no network.

Rule 1: simulated time advances only by ticks. Wall-clock time is an argument and decides only about
        processes: which are missing, which have died, and how long the last messages may take.
Rule 2: `running` ends on the first of these, and is followed by `over`, `closing`, and the judgement:
        - every living robot has arrived;
        - of the living some have arrived, the rest is stranded for a while, or again, and nothing can move;
        - the leader has lost its route, or a loss has not healed within `HEAL_S_MAX`;
        - the time limit; all robots, or the router, stay away; a request to end.
Rule 3: without a router no robot can be heard, and no robot is declared dead for that silence. One that a
        fault has stopped shortly before the end is declared dead then, unless it has told its counts.
Rule 4: a change of the fence is told to all robots at once. A resumed world raises the fence before all else.
Rule 5: entries are judged when they are read from the timeline; once the run is over, before each look.
Rule 6: in lock-step the world waits for every living robot's answer to its last odometry; else for robots
        further behind than `world.answers` allows, so that none is lost because the machine is slow.
"""

import math
from collections.abc import Callable, Iterator, Sequence, Set
from typing import assert_never

from protocol.errors import MessageRefusedError
from protocol.fence import NOBODY_NUMBER, Change
from protocol.keys import robot_name, robot_number
from protocol.mission import start_wall_s
from protocol.process.tokens import TokenCame, TokenWent
from protocol.timeline import (
    MessageRefused,
    PromiseBroken,
    RobotAppeared,
    RobotDied,
    RobotRestarted,
    RobotReturned,
    RunEnded,
    WorldResumed,
)
from protocol.wire.messages import Drive, Phase
from world.answers import Answers, due
from world.attendance import Attendance, Coming
from world.bodies.arena import Arena
from world.bodies.bodies import Bodies
from world.commands import Command, Note, ServeScan, TellOdometry
from world.events import (
    EntryRead,
    EntryWritten,
    Event,
    FencePut,
    MessageDropped,
    OrderHeard,
    ScanAsked,
    StopAsked,
)
from world.judge.ending import ASKED, Ending
from world.judge.judgement import Judge, Judgement
from world.judge.tally import Tally
from world.record.resume import Past
from world.routing import Routing
from world.scenario.scenario import Scenario

# All of these are in docs/run.md.
LAST_WORDS_WALL_S = 2.0
HEAL_S_MAX = 60.0
STRANDED_S = 10.0  # by then a leader that has arrived has let those in that ask: they do so every second
MOVED_ON_S = 30.0  # the same while obstacles move, or have moved: by then a leader gives its route up, too
SEEN_LIVE = {"S1", "S2"}  # recorded at the moment of the violation
ROUTER_PATIENCE_WALL_S = 10.0
ROBOTS_PATIENCE_WALL_S = 10.0  # a cut between world and robots looks like the death of all robots
RETURN_WALL_S = 1.0


class World:
    """One run."""

    def __init__(
        self, scenario: Scenario, *, seed: int, wall_s: float, past: Past | None = None, in_all: int = 0
    ) -> None:
        """Start a run, or resume one from its timeline `past`: then call `resume` first."""
        robots = range(1, scenario.fleet.robots + 1)
        self.robots_in_all = max(in_all, len(robots))
        """How many robots share the machine: those of other fleets are as slow to come and to answer."""
        self.scenario = scenario
        self.arena = Arena(scenario, seed=seed, life=0 if past is None else past.life)
        self._past = past
        self.tally = Tally() if past is None else past.tally
        self.attendance = Attendance(frozenset(robots))
        self.phase = Phase.RUNNING
        self._time_s_max = scenario.time.time_s_max
        self.ending: Ending | None = None
        self.over_s = 0.0
        """Simulated time at the end of `running`."""
        self.survivors: frozenset[int] = frozenset()
        """The robots that were alive then."""
        self.judgement: Judgement | None = None  # until the run is done
        self._judge = Judge(scenario)
        self._unlawful: list[PromiseBroken] = []
        """Violations that the judge has found and that are not recorded yet."""
        self._started = False
        self._routing = Routing()
        self._returned_wall_s = -math.inf
        """When present robots could last not be heard."""
        self._phase_began_wall_s = wall_s
        self.answers = Answers(self.robots_in_all)
        self._refused = dict.fromkeys(robots, -1)

    @property
    def now_s(self) -> float:
        """Simulated time."""
        return self.arena.now_s

    @property
    def bodies(self) -> Bodies:
        """All bodies, by row."""
        return self.arena.bodies

    @property
    def started(self) -> bool:
        """Whether the clock runs: all robots have come, or the run is over without them."""
        return self._started or self.phase is not Phase.RUNNING

    @property
    def awaited(self) -> set[int]:
        """The living robots that have not answered their last odometry.

        A robot whose token vanished is included until its death is detected: otherwise lock-step would run
        ahead of the detection.
        """
        if self.phase is not Phase.RUNNING:
            return set()
        return self.attendance.living.intersection(self.answers.behind())

    def held_up(self, is_excused: Callable[[int], bool], *, wall_s: float) -> Iterator[int]:
        """The robots that the clock waits for; it waits for nobody whom a fault holds up."""
        if self.phase is Phase.RUNNING:
            late = self.answers.late(self.attendance.living, self.attendance.present, wall_s=wall_s)
            yield from (each for each in late if not is_excused(each))

    def resume(self, *, wall_s: float) -> list[Command]:
        """Resume from the timeline of a world that was killed."""
        past, gone = self._past, self.tally.counted.keys()
        assert past is not None, "a run without a past starts"
        self.attendance.recall(past.come, past.dead, gone, past.incarnations, wall_s=wall_s)
        if past.ended is not None:  # only the verdict is missing
            self.ending = next(ending for ending in Ending if past.ended.startswith(ending))
            self.tally.end(past.newest_s)  # perhaps no robot has told that it has learned of the end
            self.over_s = self.tally.over_s
            self.survivors = frozenset(self.attendance.living)
            self.phase = Phase.CLOSING
            return []
        self._returned_wall_s = wall_s
        self._started = bool(past.bodies)
        self.answers.begin(self.attendance.robots, wall_s=wall_s)
        notes = self.arena.resume(past) if self._started else []
        resumed = WorldResumed(life=past.life, entries=past.count, torn_bytes=past.torn_bytes)
        begun = [*self.arena.place(), *self.arena.restart_fence()] if self._started else []
        return [*notes, self.arena.note(resumed), *begun]

    def restart(self, *, wall_s: float) -> list[Command]:
        """Go on as a world that was started again and has restored the state of the one that was killed."""
        self.come_back(wall_s=wall_s)
        if not self._started or self.phase is not Phase.RUNNING:
            return []
        return [*self.arena.restart_fence(), *self._tell_all()]

    def come_back(self, *, wall_s: float) -> None:
        """Continue after an absence; forget the tokens, since robots may have died meanwhile."""
        self.attendance.forget_tokens(wall_s=wall_s)
        self._returned_wall_s = wall_s

    def limit(self, time_s_max: float) -> None:
        """Use this time limit from now on, instead of the scenario's."""
        self._time_s_max = time_s_max

    def handle(self, event: Event, *, wall_s: float) -> list[Command]:
        """Process an event."""
        match event:
            case OrderHeard() | FencePut() | ScanAsked():
                if event.robot != NOBODY_NUMBER:
                    self.attendance.hear(event.robot, wall_s=wall_s)
                return self._hear_robot(event, wall_s)
            case TokenCame():
                return self._note_token(event.robot, event.incarnation, wall_s)
            case TokenWent():
                self.attendance.vanish(event.robot, event.incarnation, wall_s=wall_s)
            case EntryWritten():
                self.tally.hear(event.source, event.entry)
                robot = robot_number(event.source)
                if robot is not None:
                    self.attendance.hear(robot, wall_s=wall_s)
            case EntryRead():
                self._unlawful += [each.broken for each in self._judge.hear(event.source, event.entry)]
            case MessageDropped():
                return [self.arena.note(MessageRefused(key=event.key, reason=event.reason))]
            case StopAsked():
                return self._end(ASKED[event.exit_code], wall_s) if self.phase is Phase.RUNNING else []
            case _:
                assert_never(event)
        return []

    def look(self, *, wall_s: float, router: str | None = "") -> list[Command]:
        """Advance to the next phase if it is time.

        Args:
            wall_s: the wall clock.
            router: the connected router; None: there is none, so a silent robot need not have died.
        """
        if self._past is not None and self._past.ended is not None:
            return self._judge_again()
        news = [self.arena.note(each) for each in self._routing.look(router, wall_s=wall_s)]
        if router is None or news:
            self.attendance.restart_silence(wall_s=wall_s)
            self._returned_wall_s = wall_s
        unlawful = self._take_unlawful()
        if not self._is_cut_off(wall_s):
            return [*news, *unlawful, *self._look(wall_s)]
        patient = self.phase is not Phase.RUNNING or self._routing.away_s(wall_s) < ROUTER_PATIENCE_WALL_S
        return [*news, *unlawful, *([] if patient else self._end(Ending.CUT_OFF, wall_s))]

    def _look(self, wall_s: float) -> list[Command]:
        waited_s = wall_s - max(self._phase_began_wall_s, self._returned_wall_s)
        match self.phase:
            case Phase.RUNNING if not self._started:
                if not self.attendance.missing:
                    return self._start(wall_s)
                patience_s = start_wall_s(self.robots_in_all)
                return self._end(Ending.MISSING, wall_s) if waited_s >= patience_s else []
            case Phase.RUNNING:
                return self._look_after_robots(wall_s)
            case Phase.OVER:
                settled = self.attendance.living & self.attendance.present <= self.tally.settled.keys()
                if settled or waited_s >= LAST_WORDS_WALL_S:
                    return self._go_on_to(Phase.CLOSING, wall_s)
            case Phase.CLOSING:
                # All entries of a robot that ended were acknowledged: nothing more will arrive.
                gone = not self.attendance.living & self.attendance.present
                if self.judgement is None and (gone or waited_s >= LAST_WORDS_WALL_S):
                    return self._note_last_deaths() or self._end_judged()
        return []

    def _note_token(self, robot: int, incarnation: str, wall_s: float) -> list[Command]:
        """A robot's token has appeared."""
        died = robot in self.attendance.dead
        match self.attendance.appear(robot, incarnation, wall_s=wall_s):
            case Coming.NEW:
                return [self.arena.note(RobotAppeared(robot=robot, incarnation=incarnation))]
            case Coming.RESTARTED:
                deaths = [] if died else [self._note_death(robot)]
                told = self._tell([robot]) if self.started else []
                return [*deaths, self.arena.note(RobotRestarted(robot=robot, incarnation=incarnation)), *told]
            case Coming.RETURNED:
                return [self.arena.note(RobotReturned(robot=robot))]
            case Coming.KNOWN:
                return []

    def _is_cut_off(self, wall_s: float) -> bool:
        """Whether the world cannot hear its robots, or has not seen all tokens since it was reconnected.

        A request to end does not wait for that.
        """
        if self.ending is not None and self.ending in {*ASKED.values(), Ending.CUT_OFF}:
            return False
        if self._routing.away_s(wall_s) > 0.0:
            return self.phase is Phase.RUNNING or self._routing.away_s(wall_s) < ROUTER_PATIENCE_WALL_S
        if not self._started or wall_s - self._returned_wall_s >= RETURN_WALL_S:
            return False
        return bool(self.attendance.living - self.attendance.gone - self.attendance.present)

    def _look_after_robots(self, wall_s: float) -> list[Command]:
        dead = self.attendance.find_deaths(wall_s=wall_s, excused_s=self.answers.excused_s(wall_s=wall_s))
        deaths = [self._note_death(robot) for robot in dead]
        ending = self._find_ending(wall_s)
        return [*deaths, *(self._end(ending, wall_s) if ending is not None else [])]

    def tick(self) -> list[Command]:
        """Advance by one tick."""
        notes, finished = self.arena.tick()
        told = self.arena.take_scanned().union(finished)
        if self.arena.is_odometry_instant:
            told |= due(self.attendance.robots, self.arena.instant, in_all=self.robots_in_all)
        return [*notes, *self._tell(sorted(told))]

    def remind(self, robots: Set[int]) -> list[Command]:
        """Send odometry again to robots that have not answered."""
        return self._tell(sorted(robots))

    def _tell(self, robots: Sequence[int]) -> list[Command]:
        told: list[Command] = [*self.arena.sample_told(robots)]
        stood_s = self.arena.stood_s if robots else 0.0  # it looks at all bodies; most turns tell nobody
        for robot in robots:
            self.answers.tell(robot, self.now_s)
            told.append(TellOdometry(robot, self.arena.odometry(robot, self.phase, stood_s=stood_s)))
        return told

    def _tell_all(self) -> list[Command]:
        return self._tell(sorted(self.attendance.robots))

    def _hear_robot(self, event: OrderHeard | FencePut | ScanAsked, wall_s: float) -> list[Command]:
        match event:
            case OrderHeard(robot, drive):
                return self._hear_order(robot, drive, wall_s)
            case FencePut(robot, change):
                return self._change_fence(robot, change)
            case ScanAsked() if not self._started:
                return []  # a run that was over when its world was killed has no bodies any more
            case ScanAsked(robot, revolutions):
                served, scan = self.arena.scan(robot, revolutions)
                return [served, ServeScan(robot, scan)]
            case _:
                assert_never(event)

    def _change_fence(self, robot: int, change: Change) -> list[Command]:
        """Rule 4."""
        if not self._started or self.phase is not Phase.RUNNING:
            return []
        notes = self.arena.put(robot, change)
        return [*notes, *self._tell_all()] if notes else []

    def _hear_order(self, robot: int, drive: Drive, wall_s: float) -> list[Command]:
        if not self._started or self.phase is not Phase.RUNNING:
            return []  # the run is over: bodies stand, even if orders still arrive
        if drive.basis_s <= self.now_s:  # a void order is an answer too
            self.answers.answer(robot, drive.basis_s, late_s=drive.late_s, wall_s=wall_s)
        try:
            return [*self.arena.order(robot, drive)]
        except MessageRefusedError as error:
            if drive.number == self._refused[robot]:
                return []  # it is repeated with every odometry, and recorded once
            self._refused[robot] = drive.number
            return [self.arena.refusal(robot, drive, str(error))]

    def _note_death(self, robot: int) -> Note:
        return self.arena.note(RobotDied(robot=robot, silent_since_s=self.bodies.basis_s(robot - 1)))

    def _note_last_deaths(self) -> list[Command]:
        """Declare those robots dead that a fault stopped too late to be found dead while the run went on."""
        dead = self.attendance.lose(self.tally.stopped.keys() - self.tally.counted.keys())
        self.survivors -= set(dead)
        return [self._note_death(robot) for robot in dead]

    def _find_ending(self, wall_s: float) -> Ending | None:
        living, tally = self.attendance.living, self.tally
        if not living and self.attendance.silence_s(wall_s=wall_s) >= ROBOTS_PATIENCE_WALL_S:
            return Ending.EXTINCT
        if living and tally.arrived >= living:
            return Ending.ARRIVED
        if tally.arrived & living and tally.arrived | tally.stranded.keys() >= living:
            still_s = self.scenario.still_s
            again = tally.stranded_before_s > still_s and self.arena.moved_s <= tally.stranded_s
            wait_s = MOVED_ON_S if self.now_s - still_s < MOVED_ON_S else 0.0 if again else STRANDED_S
            if self.now_s - tally.changed_s >= wait_s:
                return Ending.STRANDED
        if tally.route_lost is not None:
            return Ending.ROUTE_LOST
        if tally.disturbed_s is not None:
            last_s = max(tally.disturbed_s, tally.arrived_s, self.arena.moved_s, self.arena.turn_s)
            if self.now_s - last_s >= HEAL_S_MAX:
                return Ending.STUCK
        return Ending.TIMED_OUT if self.now_s >= self._time_s_max else None

    def _start(self, wall_s: float) -> list[Command]:
        """All robots have come: place the bodies and start the clock."""
        self._started = True
        self.answers.begin(self.attendance.robots, wall_s=wall_s)
        return [*self.arena.place(), *self._tell_all()]

    def _end(self, ending: Ending, wall_s: float) -> list[Command]:
        self.ending, self.over_s = ending, self.now_s
        self.tally.end(self.now_s)
        self.survivors = frozenset(self.attendance.living)
        self.bodies.stand()
        return [*(self.arena.sample() if self._started else []), *self._go_on_to(Phase.OVER, wall_s)]

    def _go_on_to(self, phase: Phase, wall_s: float) -> list[Command]:
        self.phase, self._phase_began_wall_s = phase, wall_s
        return self._tell_all()

    def _take_unlawful(self) -> list[Command]:
        """The violations to record: S1 and S2 are recorded live, and a resumed world finds old ones again."""
        if not self._unlawful:
            return []
        known = set[PromiseBroken]() if self._past is None else self._past.unlawful
        found, self._unlawful = self._unlawful, []
        return [
            self.arena.note(each) for each in found if each.invariant not in SEEN_LIVE and each not in known
        ]

    def _end_judged(self) -> list[Command]:
        """Judge the run by the timeline alone, so that others can repeat it; then record the end."""
        assert self.ending is not None, "judged before the run was over"
        self._unlawful += [each.broken for each in self._judge.close()]
        self.judgement = self._judge.judgement
        stranded = self.tally.stranded_among(self.attendance.living)
        about = {Ending.MISSING: self.attendance.missing, Ending.STRANDED: stranded}.get(self.ending)
        reason = str(self.ending) if about is None else f"{self.ending}: {', '.join(map(robot_name, about))}"
        return [*self._take_unlawful(), self.arena.note(RunEnded(reason=reason))]

    def _judge_again(self) -> list[Command]:
        """The killed world had recorded the end: only its verdict is missing."""
        self._judge.close()
        self.judgement = self._judge.judgement
        return []
