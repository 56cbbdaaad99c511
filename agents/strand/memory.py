"""What a robot takes along from one strand to the next, whatever its place was in the one before."""

from agents.strand.leader import Leader
from protocol.frames import Pose
from protocol.mission import Mission
from protocol.wire.messages import Dissolution, Handover


class Memory:
    """What it has seen while it led, and what was handed to it."""

    def __init__(self, mission: Mission) -> None:
        self._mission = mission
        self._leader: Leader | None = None
        self._handed = b""  # what another robot has seen, unpacked only when it is needed
        self.handover = Handover(number=0, steps=0, dissolved=0, seen=b"")
        """The newest that a leader has handed on, this robot or another."""
        self.dissolved = 0
        """How often a strand has dissolved by now."""

    @property
    def seen(self) -> bytes:
        """What guidance remembers, for another robot's."""
        return self._leader.map.packed() if self._leader is not None else self._handed

    def take(self, seen: bytes) -> None:
        """Another robot has led and hands on what it has seen."""
        self._handed = seen
        if self._leader is not None:
            self._leader.map.reopen()

    def succeed(self, handover: Handover) -> None:
        """The robot ahead has handed on what the leader knows."""
        if handover.number > self.handover.number:
            self.handover = handover
            self._handed = handover.seen
            self.dissolved = max(self.dissolved, handover.dissolved)

    def hand_on(self, acknowledged: int) -> None:
        """This robot leads and has seen more; those behind may have had newer than it was handed."""
        assert self._leader is not None, "only who leads hands on"
        number, steps = max(self.handover.number, acknowledged) + 1, self._leader.steps
        self.handover = Handover(number=number, steps=steps, dissolved=self.dissolved, seen=self.seen)

    def part(self, dissolution: Dissolution) -> None:
        """The strand has dissolved."""
        self.take(dissolution.seen)
        self.dissolved = dissolution.times

    def leader(self, here: Pose) -> Leader:
        """The leader in this robot, with what was handed to it."""
        if self._leader is None:
            self._leader = Leader(self._mission, here)
        self._leader.steps = max(self._leader.steps, self.handover.steps)
        if self._handed:
            self._leader.map.unpack(self._handed)
            self._handed = b""
        return self._leader
