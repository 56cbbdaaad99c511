"""What a view agrees on, from the reports of its robots. Pure."""

from collections.abc import Mapping, Sequence, Set
from dataclasses import dataclass, field

import numpy as np
from msgspec.structs import replace

from agents.commands import Command, Note
from agents.coordinating.folding import Legs
from agents.coordinating.formation import Plan, lay_path
from agents.coordinating.order import places_of, positions
from agents.coordinating.turnabout import Turning, turned_round
from agents.strand.member import IN_VAIN_MAX
from protocol.arrays import distances_to_segments, xy
from protocol.fence import Cause, Epoch
from protocol.frames import METRES_MAX, Point, one_more
from protocol.mission import Bounds
from protocol.path import Path
from protocol.timeline import RobotStranded
from protocol.wire.codec import fits
from protocol.wire.view import Counters, Report

Reports = Mapping[int, Report]
NO_WAY = "it finds no way to a place behind the others"
NO_ROOM = "the strand has too many robots and corners for one message: make several fleets"
IN_VAIN = 2  # attempts of a strand: one by each of its ends, or by two of its robots
LEFT_OUT_PART = 20  # of a strand that is too long: so much of it is left out at a time


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

    robot: int
    """The coordinator."""
    epoch: Epoch
    intent: Intent
    sensed: bool
    """Whether robots took scans to find the order."""
    path_bounds: Bounds | None = None
    """In which the path is laid."""

    def drafted(self, order: Sequence[int], legs: Legs, reports: Reports, *, turn: int) -> Plan:
        """The formation of a drafted strand; of its front, if a message can tell no more."""
        while True:
            laid = lay_path(order, places_of(reports), legs, self.path_bounds)
            driven = frozenset(legs).intersection(order[1:])
            plan = self._plan(tuple(order), laid, driven, reports, turn=turn)
            if len(order) == 1 or (plan.path.end_m <= METRES_MAX and fits(plan.as_record())):
                return plan
            order = order[: -1 - len(order) // LEFT_OUT_PART]

    def turned(self, reports: Reports, *, turn: int) -> Plan | None:
        """The formation of a strand that turns round; None if the view is not for that, or lacks a robot."""
        turning = self.intent.turning
        if turning is None or (found := turned_round(turning, reports)) is None:
            return None
        order, path, places_m = found
        back_by_m, driven = turning.turnabout.back_by_m, frozenset(order[1:])
        plan = self._plan(order, (path, places_m), driven, reports, turn=turn, back_by_m=back_by_m)
        return plan if fits(plan.as_record()) else None

    def stranded(self, plan: Plan, reports: Reports, no_room: frozenset[int]) -> list[Command]:
        """A record for each robot that has reported and has no place in the formation.

        `no_room`: those that have none because a message is not long enough.
        """
        return [
            Note(
                RobotStranded(
                    epoch=self.epoch.number,
                    robot=robot,
                    reason=NO_ROOM if robot in no_room else NO_WAY,
                    by=self._in_the_way(robot, plan.order[-1], reports),
                )
            )
            for robot in sorted(reports.keys() - set(plan.order))
        ]

    def _in_the_way(self, robot: int, ahead: int, reports: Reports) -> int | None:
        """Whose body stands between two robots, as far as is known: the nearest of those that are lost."""
        lost = [(each, place) for each, place in self.intent.neighbours.items() if each not in reports]
        way = positions(places_of(reports), (robot, ahead))
        off_m = [float(distances_to_segments(xy(place), *way)) for _, place in lost]
        return lost[int(np.argmin(off_m))][0] if lost else None

    def counters(self, reports: Reports) -> Counters:
        """What the fleet has counted; the coordinator's own count includes what it proposed the view for.

        Attempts in vain that only others tell of are cut to `IN_VAIN_MAX`. So a leader loses its route only
        after one more attempt of its own; else one report of a robot that lies would end the run for all.
        """
        own, newest = reports[self.robot], _newest(reports)
        told = replace(newest.counters, in_vain=min(newest.counters.in_vain, IN_VAIN_MAX))
        counters = own.counters if own.counted == newest.counted else told
        return replace(
            _last_to_lead(counters, reports, newest.counted),
            steps=max(report.counters.steps for report in reports.values()),
            heals=one_more(counters.heals) if self.intent.heals else counters.heals,
        )

    def _plan(
        self,
        order: tuple[int, ...],
        laid: tuple[Path, Mapping[int, float]],
        driven: frozenset[int],
        reports: Reports,
        *,
        turn: int,
        back_by_m: float = 0.0,
    ) -> Plan:
        newest = reports[_newest_map(reports)]
        return Plan(
            epoch=self.epoch,
            turn=turn,
            order=order,
            lives={robot: reports[robot].life for robot in order},
            places={robot: reports[robot].place for robot in order},
            path=laid[0],
            places_m=laid[1],
            driven=driven,
            back_by_m=back_by_m,
            counters=self.counters(reports),
            heals=self.intent.heals,
            led_by=self.intent.led_by,
            map_number=newest.map_number,
            seen=newest.seen if newest.map_number > reports[order[0]].map_number else None,
            sensed=self.sensed,
        )


def newer_map(reports: Reports, leader: int) -> Set[int]:
    """The robot that has a newer map than the leader, if there is one."""
    robot = _newest_map(reports)
    return {robot} if reports[robot].map_number > reports[leader].map_number else frozenset()


def _newest_map(reports: Reports) -> int:
    """A robot that has the newest map; if several have it, one that has told it."""
    return max(reports, key=lambda robot: (reports[robot].map_number, reports[robot].seen is not None))


def _last_to_lead(counters: Counters, reports: Reports, ended: Epoch) -> Counters:
    """Note which robots lead only after all others.

    After `IN_VAIN` attempts in vain all robots of the strand are among them, those that have not led first,
    if another robot is there that may lead. Then attempts are counted anew.
    """
    last = tuple(dict.fromkeys(counters.last_to_lead))  # a robot may have told one twice
    of_strand = {robot for robot, report in reports.items() if report.counted == ended}
    if counters.in_vain < IN_VAIN or reports.keys() <= of_strand.union(last):
        return replace(counters, last_to_lead=last)
    return replace(counters, in_vain=0, last_to_lead=(*sorted(of_strand.difference(last)), *last))


def _newest(reports: Reports) -> Report:
    """A report of the newest strand."""
    return max(reports.values(), key=lambda report: report.counted.number)
