"""The world of one run, without clock or network: bodies, scans, what is recorded, when the run is over.

Rule 1: simulated time goes on by ticks alone. Wall-clock time is an argument and decides only what
        concerns processes: who is missing, who has died, how long last words may take.
Rule 2: `running` ends when every robot has arrived, a route is lost, a robot died and nothing moves any
        more, the time is up, or somebody interrupts. Then comes `over`, then `closing`, then it is done.
Rule 3: in lock-step the world waits for every living robot's answer to the last odometry told to it.
"""

from collections.abc import Iterable
from typing import assert_never

import numpy as np

from protocol.errors import MessageRefusedError
from protocol.keys import robot_name, robot_number
from protocol.messages import Odometry, Phase
from protocol.timeline import (
    BodyStopped,
    MessageRefused,
    OrderAccepted,
    OrderFinished,
    PoseSampled,
    Record,
    RobotAppeared,
    RobotDied,
    RunEnded,
    ScanServed,
)
from world.attendance import Attendance
from world.authority import Evidence
from world.bodies import Bodies, Floats, Moves
from world.chance import stream
from world.commands import Command, Note, ServeScan, TellOdometry
from world.ending import Ending
from world.events import (
    EntryWritten,
    Event,
    MessageDropped,
    OrderHeard,
    ScanAsked,
    StopAsked,
    TokenCame,
    TokenWent,
)
from world.judgement import Judgement, judge_evidence
from world.monitor import Monitor, Promises
from world.scenario import Scenario
from world.sensor import Sensor
from world.tally import Tally

# All of these are in docs/run.md.
TICK_S = 0.02
ODOMETRY_TICKS = 5
MUSTER_WALL_S = 10.0
LAST_WORDS_WALL_S = 2.0
STILL_S = 2.0
STILL_S_MAX = 10.0


class World:
    """One run. Robot k is row k - 1 of all arrays."""

    def __init__(self, scenario: Scenario, *, seed: int, wall_s: float) -> None:
        robots = range(1, scenario.fleet.robots + 1)
        self.scenario = scenario
        self.bodies = Bodies(
            scenario.fleet.poses(), scenario.drive, [stream(seed, f"drive/{robot}") for robot in robots]
        )
        self.tally = Tally()
        self.attendance = Attendance(frozenset(robots))
        self.phase = Phase.RUNNING
        self.ending: Ending | None = None
        self.over_s = 0.0
        """When the run was over."""
        self.judgement: Judgement | None = None
        """What came of it; None until it is done."""
        self._sensor = Sensor(scenario, [stream(seed, f"scan/{robot}") for robot in robots])
        self._monitor = Monitor(scenario.ground, Promises.of(scenario))
        self._evidence = Evidence()
        self._started = False
        self._ticks = 0
        self._phase_began_wall_s = wall_s
        self._moved_s = 0.0
        self._order_clearance_m = np.full(len(robots), np.inf)
        self._told_s = dict.fromkeys(robots, -1.0)
        self._answered_s = dict.fromkeys(robots, -1.0)

    @property
    def now_s(self) -> float:
        """Simulated time."""
        return self._ticks * TICK_S

    @property
    def started(self) -> bool:
        """Whether the clock runs: all robots have come, or the run is over without."""
        return self._started or self.phase is not Phase.RUNNING

    @property
    def awaited(self) -> set[int]:
        """The living robots that have not answered the last odometry told to them.

        One whose token has gone is among them until it is known to have died: lock-step would else run
        ahead of that.
        """
        if self.phase is not Phase.RUNNING:
            return set()
        owing = {robot for robot, told_s in self._told_s.items() if self._answered_s[robot] < told_s}
        return owing & self.attendance.living

    def handle(self, event: Event, *, wall_s: float) -> list[Command]:
        """Take an event in."""
        match event:
            case OrderHeard():
                self.attendance.hear(event.robot, wall_s=wall_s)
                return self._hear_order(event)
            case ScanAsked():
                self.attendance.hear(event.robot, wall_s=wall_s)
                return self._read_scan(event.robot)
            case TokenCame():
                new = self.attendance.appear(event.robot, event.incarnation, wall_s=wall_s)
                return [self._note(RobotAppeared(robot=event.robot))] if new else []
            case TokenWent():
                self.attendance.vanish(event.robot, event.incarnation)
            case EntryWritten():
                self.tally.hear(event.source, event.entry)
                self._evidence.hear(event.source, event.entry)
                robot = robot_number(event.source)
                if robot is not None:
                    self.attendance.hear(robot, wall_s=wall_s)
            case MessageDropped():
                return [self._note(MessageRefused(key=event.key, reason=event.reason))]
            case StopAsked():
                return self._end(Ending.INTERRUPTED, wall_s) if self.phase is Phase.RUNNING else []
            case _:
                assert_never(event)
        return []

    def look(self, *, wall_s: float) -> list[Command]:
        """See whether it is time for the next phase."""
        waited_s = wall_s - self._phase_began_wall_s
        match self.phase:
            case Phase.RUNNING if not self._started:
                if not self.attendance.missing:
                    return self._start()
                return self._end(Ending.MISSING, wall_s) if waited_s >= MUSTER_WALL_S else []
            case Phase.RUNNING:
                deaths = [self._die(robot) for robot in self.attendance.bury(wall_s=wall_s)]
                ending = self._find_ending()
                return [*deaths, *(self._end(ending, wall_s) if ending is not None else [])]
            case Phase.OVER:
                settled = self.attendance.living & self.attendance.present <= self.tally.settled.keys()
                if settled or waited_s >= LAST_WORDS_WALL_S:
                    return self._go_on_to(Phase.CLOSING, wall_s)
            case Phase.CLOSING:
                # A robot that has gone had all its entries acknowledged: nothing more will come.
                gone = not self.attendance.living & self.attendance.present
                if self.judgement is None and (gone or waited_s >= LAST_WORDS_WALL_S):
                    return self._judge()
        return []

    def tick(self) -> list[Command]:
        """Go on by one tick."""
        began_s, headings_rad, moving = self.now_s, self.bodies.heading_rad, self.bodies.moving
        moves = self.bodies.tick(now_s=began_s, tick_s=TICK_S)
        told = moving if self._ticks % ODOMETRY_TICKS == 0 else np.zeros_like(moving)
        notes: list[Command] = [
            Note(began_s, _sample(body, moves.starts_m, headings_rad))
            for body in np.flatnonzero(told | moves.veered).tolist()
        ]
        self._ticks += 1
        notes += [self._note(BodyStopped(robot=body + 1)) for body in moves.stopped]
        notes += self._watch(moves)
        notes += [self._note(self._finish(body)) for body in moves.finished]
        if self.bodies.moving.any():
            self._moved_s = self.now_s
        all_bodies = range(self.scenario.fleet.robots)
        return notes + self._tell(all_bodies if self._ticks % ODOMETRY_TICKS == 0 else moves.finished)

    def remind(self) -> list[Command]:
        """Tell the robots that owe an answer once more what they have to answer."""
        return self._tell(robot - 1 for robot in sorted(self.awaited))

    def _note(self, record: Record) -> Note:
        return Note(self.now_s, record)

    def _tell(self, bodies: Iterable[int]) -> list[Command]:
        told: list[Command] = []
        for body in bodies:
            self._told_s[body + 1] = self.now_s
            odometry = Odometry(
                t_s=self.now_s,
                pose=self.bodies.pose(body),
                moving=bool(self.bodies.moving[body]),
                finished=self.bodies.finished_number[body],
                phase=self.phase,
            )
            told.append(TellOdometry(body + 1, odometry))
        return told

    def _tell_all(self) -> list[Command]:
        return self._tell(range(self.scenario.fleet.robots))

    def _hear_order(self, event: OrderHeard) -> list[Command]:
        if not self._started or self.phase is not Phase.RUNNING:
            return []  # the run is over: bodies stand, whatever was still on its way
        body, drive = event.robot - 1, event.drive
        try:
            new = self.bodies.hear(body, drive, now_s=self.now_s)
        except MessageRefusedError as error:
            return [
                self._note(MessageRefused(key=f"body/{robot_name(event.robot)}/drive", reason=str(error)))
            ]
        self._answered_s[event.robot] = max(self._answered_s[event.robot], drive.basis_s)
        if not new:
            return []
        self._order_clearance_m[body] = np.inf
        pose = self.bodies.pose(body)
        accepted = OrderAccepted(
            robot=event.robot,
            number=drive.number,
            epoch=drive.epoch,
            step=drive.step,
            x_m=pose.x_m,
            y_m=pose.y_m,
            target=drive.target,
            reach_m=drive.reach_m,
        )
        return [self._note(accepted)]

    def _read_scan(self, robot: int) -> list[Command]:
        pose = self.bodies.pose(robot - 1)
        scan = self._sensor.read(robot - 1, pose, self.bodies.place_m, now_s=self.now_s)
        served = ScanServed(
            robot=robot,
            x_m=pose.x_m,
            y_m=pose.y_m,
            heading_rad=pose.heading_rad,
            hits=self._sensor.hits(scan),
        )
        return [self._note(served), ServeScan(robot, scan)]

    def _watch(self, moves: Moves) -> list[Command]:
        broken = self._monitor.watch(moves.starts_m, moves.ends_m, t_s=self.now_s)
        np.minimum(self._order_clearance_m, self._monitor.clearance_m, out=self._order_clearance_m)
        return [self._note(each) for each in broken]

    def _finish(self, body: int) -> OrderFinished:
        order = self.bodies.orders[body]
        assert order is not None, f"body {body} finished without an order"
        pose = self.bodies.pose(body)
        clearance_m = float(self._order_clearance_m[body])
        return OrderFinished(
            robot=body + 1,
            number=order.number,
            step=order.step,
            x_m=pose.x_m,
            y_m=pose.y_m,
            clearance_m=clearance_m if clearance_m < np.inf else None,
        )

    def _die(self, robot: int) -> Note:
        return self._note(RobotDied(robot=robot, silent_since_s=self.bodies.heard_s(robot - 1)))

    def _find_ending(self) -> Ending | None:
        if self.tally.arrived >= self.attendance.robots:
            return Ending.ARRIVED
        if self.tally.route_lost is not None:
            return Ending.ROUTE_LOST
        if self.tally.deaths:
            died_s = self.tally.deaths[-1][0]
            still_s = self.now_s - max(died_s, self._moved_s)
            if still_s >= STILL_S or self.now_s - died_s >= STILL_S_MAX:
                return Ending.DEATH
        return Ending.TIMED_OUT if self.now_s >= self.scenario.time.time_s_max else None

    def _start(self) -> list[Command]:
        """All robots have come: place the bodies, and let the clock run."""
        self._started = True
        places_m = self.bodies.place_m
        broken = self._monitor.watch(places_m, places_m, t_s=self.now_s)
        return [*self._sample_all(), *(self._note(each) for each in broken), *self._tell_all()]

    def _sample_all(self) -> list[Command]:
        places_m, headings_rad = self.bodies.place_m, self.bodies.heading_rad
        return [self._note(_sample(body, places_m, headings_rad)) for body in range(len(places_m))]

    def _end(self, ending: Ending, wall_s: float) -> list[Command]:
        self.ending, self.over_s = ending, self.now_s
        samples = self._sample_all() if self._started else []
        self.bodies.stand()
        return samples + self._go_on_to(Phase.OVER, wall_s)

    def _go_on_to(self, phase: Phase, wall_s: float) -> list[Command]:
        self.phase, self._phase_began_wall_s = phase, wall_s
        return self._tell_all()

    def _judge(self) -> list[Command]:
        """Judge by the timeline alone, as anybody can after us; only then is the run ended."""
        assert self.ending is not None, "judged before the run was over"
        self.judgement = judge_evidence(self.scenario, self._evidence)
        unlawful = [each.broken for each in self.judgement.breaches if each.broken.invariant == "S3"]
        reason = str(self.ending)
        if self.ending is Ending.MISSING:
            reason += f": {', '.join(map(robot_name, self.attendance.missing))}"
        return [*map(self._note, unlawful), self._note(RunEnded(reason=reason))]


def _sample(body: int, places_m: Floats, headings_rad: Floats) -> PoseSampled:
    x_m, y_m = places_m[body].tolist()
    return PoseSampled(robot=body + 1, x_m=x_m, y_m=y_m, heading_rad=float(headings_rad[body]))
