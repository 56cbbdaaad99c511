"""Entries of robots about strands, musters, queues and failures, as evidence for the judgement."""

from collections import defaultdict
from dataclasses import dataclass, field

from protocol.keys import robot_number
from protocol.timeline import (
    AuthorityGranted,
    Entry,
    LeaderSucceeded,
    MusterCalled,
    MusterJoined,
    RobotFailed,
    RobotStarted,
    StepPlanned,
    StrandFormed,
    StrandHealed,
    TrafficCounted,
)

Told = (
    RobotStarted
    | RobotFailed
    | StrandFormed
    | StrandHealed
    | LeaderSucceeded
    | StepPlanned
    | AuthorityGranted
    | MusterCalled
    | MusterJoined
    | TrafficCounted
)


@dataclass(slots=True)
class History:
    """The relevant entries with their times, by robot and in order."""

    told: dict[int, list[tuple[float, Told]]] = field(default_factory=lambda: defaultdict(list))
    strands: dict[int, tuple[int, StrandFormed]] = field(default_factory=dict)
    """By epoch: the first robot recorded in the strand, and its entry."""
    members: dict[int, tuple[int, ...]] = field(default_factory=dict)
    """The robots that were called to a muster, by its epoch."""
    holes: list[tuple[float, int, int]] = field(default_factory=list)
    """Gaps in the entry numbers of a robot: time, robot, next number."""
    _counts: dict[int, int] = field(default_factory=dict)

    def hear(self, source: str, entry: Entry) -> None:
        """Process an entry; the entries of one source come in order, sources in any order."""
        robot = robot_number(source)
        if robot is None:
            return
        if entry.n not in {self._counts.get(robot, 0) + 1, 1}:  # a new process counts from 1
            self.holes.append((entry.t_s, robot, entry.n))
        self._counts[robot] = entry.n
        record = entry.record
        if not isinstance(record, Told):
            return
        self.told[robot].append((entry.t_s, record))
        if isinstance(record, StrandFormed):
            self.strands.setdefault(record.epoch, (robot, record))
        elif isinstance(record, MusterCalled):
            self.members.setdefault(record.epoch, record.members)

    def joined(self, robot: int) -> list[tuple[float, int]]:
        """The musters that a robot joined: time and epoch."""
        return [(t_s, each.epoch) for t_s, each in self.told.get(robot, ()) if isinstance(each, MusterJoined)]
