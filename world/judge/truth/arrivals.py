"""A1 and A2: what robots record of their arrival, held against true poses. Pure; entry by entry.

Rule 1 (A1): at `goal.reached` the robot stands within the goal's tolerance, and mu0, of the goal; without a
        goal, within mu0 of its last switching position.
Rule 2 (A2): at `robot.arrived` the robot stands at the arc length of the strand's path that it names, within
        mu0. The leader has reached the goal in that epoch. For any other robot, the one ahead has arrived in
        that epoch, and the way up to that one is driven: `mu0` further on it would come nearer to the rest of
        that one's path than ground is granted. It is not nearer than robots keep, unless its place in the
        formation is.
Rule 3 (A2): from then on it stands, as long as the epoch is in force.
Rule 4: entries of different sources come in any order. So a claim waits for the world's next entry, which
        shows where the body stood; for the formation; and for the claim of the robot ahead. A robot that has
        not recorded its last entry may have arrived unheard: nobody behind it is judged by that.
"""

from collections import defaultdict, deque
from collections.abc import Iterable, Iterator
from dataclasses import dataclass, replace
from typing import Self

from protocol.arrays import segments_apart
from protocol.fence import May
from protocol.frames import Point
from protocol.path import Path
from protocol.timeline import (
    Entry,
    FenceChanged,
    GoalReached,
    PoseSampled,
    PromiseBroken,
    RobotArrived,
    RobotSettled,
    RobotStarted,
    StepAbandoned,
    StepPlanned,
    StrandFormed,
)
from world.judge.rules.claims import ROUNDING_S
from world.judge.rules.evidence import ROUNDING_M, apart_m
from world.judge.rules.rule import Dated, breach_of, broken
from world.judge.truth.strand import ArrivalClaim, Strand
from world.judge.truth.track import Track
from world.scenario.scenario import Scenario

STRANDS_KEPT = 8  # late entries are of the strand before, or of one of few that were given up at once


@dataclass(frozen=True, slots=True, kw_only=True)
class Places:
    """What a scenario says of the places where robots arrive."""

    goal: Point | None
    tolerance_m: float
    mu0_m: float
    drive_error_m: float
    """The largest error of a drive as long as a scan reaches."""
    grant_keep_m: float
    """How far granted ground is from the centre of a robot that may still be there."""
    keep_m: float
    """How far a path that is laid later stays from it at least."""
    is_kept: bool
    """Whether it does."""

    @classmethod
    def of(cls, scenario: Scenario) -> Self:
        """Those of a scenario."""
        goal, law, mission = scenario.goal, scenario.law, scenario.mission()
        error_m = scenario.drive.heading_error_rad * scenario.range_m_used
        return cls(
            goal=None if goal is None else Point(x_m=goal.at_m[0], y_m=goal.at_m[1]),
            tolerance_m=0.0 if goal is None else goal.tolerance_m,
            mu0_m=law.mu0_m,
            drive_error_m=0.0 if law.promises_clearance else error_m,
            grant_keep_m=mission.grant_keep_m,
            keep_m=mission.robot_keep_m,
            is_kept=law.promises_clearance,
        )

    @property
    def off_m_max(self) -> float:
        """How far a robot may stand from where it drove. Under a law with promises mu0 covers the drive."""
        return self.mu0_m + self.drive_error_m + ROUNDING_M


class Arrivals:
    """Judges the arrivals of one run."""

    def __init__(self, places: Places) -> None:
        self._places = places
        self._tracks: dict[int, Track] = defaultdict(Track)
        self._strands: dict[int, Strand] = defaultdict(Strand)
        self._epoch = 0
        """The epoch in force."""
        self._stands: dict[int, Point] = {}
        """Where the robots stand that have arrived in that epoch."""
        self._claims: list[ArrivalClaim] = []
        """Those that wait for the world."""
        self._told_s: dict[int, float] = {}
        """The time of each robot's newest entry."""
        self._ended: set[int] = set()
        """The robots of which no claim can be missing."""
        self._again: set[int] = set()
        """The robots that were started again: the last entries of the process before may be missing."""

    def hear_world(self, entry: Entry) -> Iterator[Dated]:
        """Process an entry of the world."""
        match entry.record:
            case PoseSampled(robot=robot) as pose:
                self._tracks[robot].hear(entry.t_s, pose)
                yield from self._judge_motion(entry.t_s, pose)
            case FenceChanged() as change:
                self._change_fence(entry.t_s, change)
            case _:
                pass  # shows nothing but the time
        due = [claim for claim in self._claims if claim.t_s < entry.t_s - ROUNDING_S]
        if due:
            self._claims = [claim for claim in self._claims if claim.t_s >= entry.t_s - ROUNDING_S]
            yield from self._look_at(due)

    def hear_robot(self, robot: int, entry: Entry, epoch: int | None) -> Iterator[Dated]:
        """Process an entry of a robot that has its place in the strand of this epoch."""
        t_s = entry.t_s
        match entry.record:
            case GoalReached() if epoch is not None:
                self._strands[epoch].reached.add(robot)
                self._claims.append(ArrivalClaim(t_s, robot, epoch, None))
            case RobotArrived(progress_m=progress_m) if epoch is not None:
                self._claims.append(ArrivalClaim(t_s, robot, epoch, progress_m))
            case StepPlanned(joins=False) as plan if robot == self._strands[plan.epoch].leader:
                self._strands[plan.epoch].step_to(plan.step, plan.target)
            case StepAbandoned(epoch=of, step=step) as end if robot == self._strands[of].leader:
                self._strands[of].step_to(step, Point(x_m=end.x_m, y_m=end.y_m))
            case StrandFormed() as formed if self._strands[formed.epoch].formed is None:
                strand = self._strands[formed.epoch]
                strand.form(formed)
                for claim in strand.waiting.pop(0, ()):
                    yield from self._judge(strand, claim)
            case RobotStarted() if robot in self._told_s:
                self._again.add(robot)
            case RobotSettled() if robot not in self._again:
                self._ended.add(robot)
            case _:
                pass  # says nothing about arrivals
        self._told_s[robot] = max(t_s, self._told_s.get(robot, 0.0))
        if not self._claims:
            self._tracks[robot].forget(self._told_s[robot])

    def close(self) -> Iterator[Dated]:
        """Judge what still waits; there are no more entries."""
        claims, self._claims = self._claims, []
        yield from self._look_at(claims)
        for strand in self._strands.values():
            also = {claim.robot for waiting in strand.waiting.values() for claim in waiting}
            for ahead, waiting in strand.waiting.items():
                for claim in waiting if ahead in self._ended - also else ():
                    why = "says that it has arrived, and the robot ahead of it has not"
                    yield claim.t_s, broken("A2", claim.robot, why, ahead)

    def _change_fence(self, t_s: float, change: FenceChanged) -> None:
        if change.epoch != self._epoch:
            self._strands[self._epoch].end(t_s)
            self._epoch = change.epoch
            self._stands.clear()
            self._forget()
        if change.may is May.ALL:
            self._strands[change.epoch].lead(change.named)

    def _forget(self) -> None:
        """Forget the oldest strands about which no claim waits."""
        idle = [epoch for epoch, strand in self._strands.items() if not any(strand.waiting.values())]
        for epoch in sorted(idle)[:-STRANDS_KEPT]:
            del self._strands[epoch]

    def _judge_motion(self, t_s: float, pose: PoseSampled) -> Iterator[Dated]:
        """Rule 3, for a robot that is known to have arrived."""
        stands = self._stands.get(pose.robot)
        if stands is not None and (off_m := apart_m(pose, stands)) > ROUNDING_M:
            del self._stands[pose.robot]
            yield t_s, _moved(pose.robot, off_m)

    def _look_at(self, claims: Iterable[ArrivalClaim]) -> Iterator[Dated]:
        """Where the bodies stood, and whether they have moved since."""
        for claim in claims:
            stood, strand = self._tracks[claim.robot].at(claim.t_s), self._strands[claim.epoch]
            if stood is None:
                continue  # the run ended before the bodies were placed
            off_m = self._tracks[claim.robot].off_m(stood, claim.t_s, strand.until_s)
            if off_m > ROUNDING_M:
                strand.untrue.add(claim.robot)
                yield claim.t_s, _moved(claim.robot, off_m)
            elif claim.epoch == self._epoch:
                self._stands[claim.robot] = stood
            seen = replace(claim, stood=stood)
            if strand.formed is None:
                strand.waiting[0].append(seen)
            else:
                yield from self._judge(strand, seen)

    def _judge(self, strand: Strand, claim: ArrivalClaim) -> Iterator[Dated]:
        """Rules 1 and 2, for a claim and for those that wait for it."""
        assert strand.formed is not None, "claims wait for the formation"
        if claim.robot not in strand.ranks or not strand.formed.laid:
            return  # F4 and P3 judge that
        due = deque([claim])
        while due:
            each = due.popleft()
            if each.progress_m is None:
                yield from self._judge_goal(strand, each)
                continue
            ahead = strand.waits_for(each.robot)
            if ahead and ahead not in strand.arrived:
                strand.waiting[ahead].append(each)
                continue
            due.extend(strand.judge(each))
            yield from self._judge_place(strand, each, strand.arrived.get(ahead))

    def _judge_goal(self, strand: Strand, claim: ArrivalClaim) -> Iterator[Dated]:
        """Rule 1."""
        places = self._places
        assert claim.stood is not None, "it has been looked at"
        if places.goal is None:
            end, allowed_m, what = (
                strand.path.at(strand.end_m),
                places.off_m_max,
                "its last switching position",
            )
        else:
            end, allowed_m, what = places.goal, places.tolerance_m + places.mu0_m, "the goal"
        off_m = apart_m(end, claim.stood)
        if off_m > allowed_m + ROUNDING_M:
            why = f"says that it has reached {what}, and stands elsewhere"
            yield claim.t_s, breach_of("A1", claim.robot, off_m, allowed_m, why)

    def _judge_place(
        self, strand: Strand, claim: ArrivalClaim, ahead: ArrivalClaim | None
    ) -> Iterator[Dated]:
        """Rule 2."""
        assert claim.stood is not None, "it has been looked at"
        assert claim.progress_m is not None, "it claims a place"
        robot, places, path = claim.robot, self._places, strand.path
        off_m = apart_m(path.at(claim.progress_m), claim.stood)
        if off_m > places.off_m_max:
            strand.untrue.add(robot)
            why = "says that it has arrived, and does not stand there on its path"
            yield claim.t_s, breach_of("A2", robot, off_m, places.off_m_max, why)
        elif ahead is None and robot not in strand.reached:
            yield claim.t_s, broken("A2", robot, "says that it has arrived, and not that the goal is reached")
        elif ahead is not None and ahead.progress_m is not None and ahead.robot not in strand.untrue:
            yield from self._judge_gap(strand, claim, claim.progress_m, ahead.robot, ahead.progress_m)

    def _judge_gap(
        self, strand: Strand, claim: ArrivalClaim, progress_m: float, ahead: int, ahead_m: float
    ) -> Iterator[Dated]:
        """Rule 2, between a robot and the one ahead."""
        places, path = self._places, strand.path
        most_m, least_m = places.grant_keep_m + ROUNDING_M, places.keep_m - ROUNDING_M
        on_m = _apart_m(path, progress_m, ahead_m, places.mu0_m)
        if on_m > most_m:
            why = "says that it has arrived, and has not come up to the robot ahead"
            yield claim.t_s, breach_of("A2", claim.robot, on_m, most_m, why, other=ahead)
        has_come = places.is_kept and progress_m > strand.place_m(claim.robot) + ROUNDING_M
        if has_come and (apart_m := _apart_m(path, progress_m, ahead_m, 0.0)) < least_m:
            why = "has come nearer to the robot ahead than robots keep"
            yield claim.t_s, breach_of("A2", claim.robot, apart_m, least_m, why, other=ahead)


def _apart_m(path: Path, progress_m: float, ahead_m: float, more_m: float) -> float:
    """How near the next metres of a path come to what is left of it for the robot ahead."""
    way = path.between(progress_m, min(progress_m + more_m, max(ahead_m, progress_m)))
    ground = path.between(ahead_m, path.end_m)
    starts, ends = way[:-1, None], way[1:, None]
    return float(segments_apart(starts, ends, ground[None, :-1], ground[None, 1:]).min())


def _moved(robot: int, off_m: float) -> PromiseBroken:
    return breach_of("A2", robot, off_m, 0.0, "moved after it had arrived")
