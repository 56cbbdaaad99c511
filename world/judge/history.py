"""What robots have said of strands, musters, queues and failures, for whoever judges a run by it."""

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
    """Each entry that matters with its time, by robot and in its order."""

    told: dict[int, list[tuple[float, Told]]] = field(default_factory=lambda: defaultdict(list))
    strands: dict[int, tuple[int, StrandFormed]] = field(default_factory=dict)
    """By epoch: the first robot that was recorded to have its place in it, and how it saw it."""
    members: dict[int, tuple[int, ...]] = field(default_factory=dict)
    """Who was called to a muster, by its epoch."""
    holes: list[tuple[float, int, int]] = field(default_factory=list)
    """When a robot's count did not go on by one, which robot, and how it went on."""
    _counts: dict[int, int] = field(default_factory=dict)

    def hear(self, source: str, entry: Entry) -> None:
        """Take an entry in; those of one source come in their order, sources in any."""
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
        """When a robot joined which muster, by its epoch."""
        return [(t_s, each.epoch) for t_s, each in self.told.get(robot, ()) if isinstance(each, MusterJoined)]
