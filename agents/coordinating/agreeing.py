"""What a view agrees on, from the reports of its robots. Pure.

Rule 1: a strand turns round only if all its robots have reported places on its path, in its order, and each
        only one. Otherwise the view drafts a strand as any other view does.
"""

from collections.abc import Collection, Mapping, Sequence, Set
from dataclasses import dataclass, field

from msgspec.structs import replace

from agents.commands import Command, Note
from agents.coordinating.folding import Legs
from agents.coordinating.formation import Laid, Plan, lay_path
from agents.coordinating.order import Reports, places_of, positions
from agents.liveness.reason import Turnabout
from agents.strand.member import IN_VAIN_MAX
from protocol.arrays import distances_to_segments, xy
from protocol.fence import Cause, Epoch
from protocol.frames import METRES_MAX, Point, one_more
from protocol.mission import Mission
from protocol.path import Path
from protocol.timeline import RobotStranded
from protocol.wire.codec import fits
from protocol.wire.view import STRANDED_MAX, Counters, Formation, Neighbour

NO_WAY = "it finds no way to a place behind the others"
NO_ROOM = "the strand has too many robots and corners for one message: make several fleets"
IN_VAIN = 2  # attempts of a strand: one by each of its ends, or by two of its robots
LEFT_OUT_PART = 20  # of a strand that is too long: so much of it is left out at a time


@dataclass(frozen=True, slots=True)
class Turning:
    """A strand that is to turn round."""

    turnabout: Turnabout
    """Where the new path begins and ends, in arc lengths of the old one."""
    formation: Formation
    path: Path
    """The old one, as the robot that leads knows it."""

    def turned(self, reports: Reports) -> tuple[tuple[int, ...], Laid] | None:
        """Rule 1: the order and the path, both reversed."""
        at = sorted(
            (former.rank, robot, former.s_m)
            for robot, report in reports.items()
            for former in report.formers
            if former.epoch == self.formation.epoch and not former.draft
        )
        order = tuple(robot for _, robot, _ in reversed(at))
        if [rank for rank, _, _ in at] != [*range(self.formation.members)] or len({*order}) < len(order):
            return None
        end_m, tail_m = self.turnabout.end_m, min(s_m for *_, s_m in at)  # the leader may have old news of it
        leads_from_there = self.turnabout.back_by_m == 0.0
        cut_m = tail_m if leads_from_there else min(self.turnabout.cut_m, tail_m)
        path = self.path.reversed(cut_m, end_m)
        return order, (path, {robot: min(max(end_m - s_m, 0.0), path.end_m) for _, robot, s_m in at})


@dataclass(frozen=True, slots=True)
class Intent:
    """Why the view was proposed, and what its proposer knows of the last strand."""

    cause: Cause
    led_by: int = 0
    """The leader of the last strand; 0: there was none."""
    neighbours: Mapping[int, Point] = field(default_factory=dict)
    """Where its neighbours in former strands were when it last heard them."""
    turning: Turning | None = None
    """DEAD_END: the strand that is to turn round."""

    @property
    def heals(self) -> bool:
        """Whether the view follows a loss, or a robot that was left out."""
        return self.cause not in {Cause.START, Cause.BLOCKED, Cause.DEAD_END}


@dataclass(frozen=True, slots=True)
class Agreement:
    """One coordinator's part in making the formation."""

    epoch: Epoch
    intent: Intent
    mission: Mission
    reports: Reports
    """Of the view, as they come in."""
    had_turn: Collection[int]
    """The robots for which a turn was put, as they get one."""

    def drafted(self, order: Sequence[int], legs: Legs, *, turn: int) -> Plan:
        """The formation of a drafted strand; of its front, if a message can tell no more."""
        while True:
            laid = lay_path(order, places_of(self.reports), legs, self.mission.path_bounds)
            plan = self._plan(order, laid, frozenset(legs).intersection(order[1:]), turn=turn)
            if len(order) == 1 or (laid[0].end_m <= METRES_MAX and fits(plan.as_record())):
                return plan
            order = order[: -1 - len(order) // LEFT_OUT_PART]

    def turned(self, *, turn: int) -> Plan | None:
        """The formation of a strand that turns round; None if the view is not for that, or lacks a robot."""
        turning = self.intent.turning
        if turning is None or (found := turning.turned(self.reports)) is None:
            return None
        order, laid = found
        back_by_m = turning.turnabout.back_by_m
        plan = self._plan(order, laid, frozenset(order[1:]), turn=turn, back_by_m=back_by_m)
        return plan if fits(plan.as_record()) else None

    def stranded(self, plan: Plan, no_room: Set[int]) -> list[Command]:
        """A record for each robot that has reported and has no place in the formation.

        `no_room`: those that have none because a message is not long enough.
        """
        return [
            Note(
                RobotStranded(
                    epoch=self.epoch.number,
                    robot=robot,
                    reason=NO_ROOM if robot in no_room else NO_WAY,
                    by=self._in_the_way(robot, plan.order[-1]),
                )
            )
            for robot in sorted(self.reports.keys() - set(plan.order))
        ]

    def _in_the_way(self, robot: int, ahead: int) -> int | None:
        """Whose body stands between two robots, as far as is known: the nearest of those that are lost."""
        way = positions(places_of(self.reports), (robot, ahead))
        off_m = {
            each: float(distances_to_segments(xy(place), *way))
            for each, place in self.intent.neighbours.items()
            if each not in self.reports
        }
        return min(off_m, key=off_m.__getitem__, default=None)

    def counters(self) -> Counters:
        """What the fleet has counted; the coordinator's own count includes what it proposed the view for.

        Attempts in vain that only others tell of are cut to `IN_VAIN_MAX`. So a leader loses its route only
        after one more attempt of its own; else one report of a robot that lies would end the run for all.
        """
        own = self.reports[self.epoch.robot]
        newest = max(self.reports.values(), key=lambda report: report.counted.number)
        told = replace(newest.counters, in_vain=min(newest.counters.in_vain, IN_VAIN_MAX))
        counters = own.counters if own.counted == newest.counted else told
        return replace(
            self._last_to_lead(counters, newest.counted),
            steps=max(report.counters.steps for report in self.reports.values()),
            heals=one_more(counters.heals) if self.intent.heals else counters.heals,
        )

    def _last_to_lead(self, counters: Counters, ended: Epoch) -> Counters:
        """Note which robots lead only after all others.

        After `IN_VAIN` attempts in vain all robots of the strand are among them, those that have not led
        first, if another robot is there that may lead. Then attempts are counted anew.
        """
        last = tuple(dict.fromkeys(counters.last_to_lead))  # a robot may have told one twice
        of_strand = {robot for robot, report in self.reports.items() if report.counted == ended}
        if counters.in_vain < IN_VAIN or self.reports.keys() <= of_strand.union(last):
            return replace(counters, last_to_lead=last)
        return replace(counters, in_vain=0, last_to_lead=(*sorted(of_strand.difference(last)), *last))

    def newer_map(self, leader: int) -> Set[int]:
        """The robot whose map is to be used if the leader has an older one; best one that has told it."""
        reports = self.reports
        robot = max(reports, key=lambda each: (reports[each].map_number, reports[each].seen is not None))
        return {robot} if reports[robot].map_number > reports[leader].map_number else frozenset()

    def _plan(
        self, order: Sequence[int], laid: Laid, driven: Set[int], *, turn: int, back_by_m: float = 0.0
    ) -> Plan:
        reports, (path, places_m) = self.reports, laid
        vertices, counters = tuple(path), self.counters()
        map_number = max(report.map_number for report in reports.values())
        seen = next((reports[robot].seen for robot in self.newer_map(order[0])), None)
        stranded = tuple(sorted((reports.keys() & self.had_turn) - {*order}))[:STRANDED_MAX]
        neighbours = [
            Neighbour(robot=robot, life=reports[robot].life, s_m=places_m[robot]) for robot in order
        ]
        beside = [None, *neighbours, None]
        members = {
            robot: Formation(
                epoch=self.epoch,
                life=reports[robot].life,
                turn=turn,
                members=len(order),
                rank=rank,
                s_m=places_m[robot],
                place=reports[robot].place,
                ahead=beside[rank],
                behind=beside[rank + 2],
                leg_is_driven=robot in driven,
                back_by_m=back_by_m,
                counters=counters,
                heals=self.intent.heals,
                led_by=self.intent.led_by,
                stranded=stranded,
                map_number=map_number,
                seen=None if rank else seen,
                first=0,
                vertices=len(vertices),
                path=vertices,
            )
            for rank, robot in enumerate(order)
        }
        return Plan(members, sensed=self.mission.goal is None)
