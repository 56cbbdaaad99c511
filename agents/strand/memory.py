"""What a robot keeps from one strand to the next, independent of its place."""

from agents.strand.leader import Leader
from protocol.frames import Pose
from protocol.mission import Mission
from protocol.wire.messages import Dissolution, Handover


class Memory:
    """What it has seen as leader, and what other leaders have handed over."""

    def __init__(self, mission: Mission) -> None:
        self._mission = mission
        self._leader: Leader | None = None
        self._handed = b""  # another robot's hits, unpacked only when needed
        self.handover = Handover(number=0, steps=0, dissolved=0, seen=b"")
        """The newest hand-over by a leader, this robot or another."""
        self.dissolved = 0
        """How often a strand has dissolved so far."""

    @property
    def seen(self) -> bytes:
        """The hits in the map, for another robot."""
        return self._leader.map.packed() if self._leader is not None else self._handed

    def take(self, seen: bytes) -> None:
        """Adopt what another leader has seen."""
        self._handed = seen
        if self._leader is not None:
            self._leader.map.reopen()

    def succeed(self, handover: Handover) -> None:
        """Adopt a hand-over from the robot ahead, if it is newer."""
        if handover.number > self.handover.number:
            self.handover = handover
            self._handed = handover.seen
            self.dissolved = max(self.dissolved, handover.dissolved)

    def hand_on(self, acknowledged: int) -> None:
        """Make a new hand-over as leader, newer than any that robots behind have acknowledged."""
        assert self._leader is not None, "only a leader hands over"
        number, steps = max(self.handover.number, acknowledged) + 1, self._leader.steps
        self.handover = Handover(number=number, steps=steps, dissolved=self.dissolved, seen=self.seen)

    def part(self, dissolution: Dissolution) -> None:
        """Keep what a dissolved strand leaves."""
        self.take(dissolution.seen)
        self.dissolved = dissolution.times

    def leader(self, here: Pose) -> Leader:
        """The leader of this robot, with everything that was handed over."""
        if self._leader is None:
            self._leader = Leader(self._mission, here)
        self._leader.steps = max(self._leader.steps, self.handover.steps)
        if self._handed:
            self._leader.map.unpack(self._handed)
            self._handed = b""
        return self._leader
