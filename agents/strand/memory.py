"""What a robot keeps from strand to strand, whatever its place: maps, steps, and where it knew no way on."""

import math
from collections.abc import Sequence

from msgspec.structs import replace

from agents.strand.leader import Leader
from protocol.arrays import Floats
from protocol.frames import Pose, one_more
from protocol.mission import Mission
from protocol.sweep import Place
from protocol.wire.messages import Handover
from protocol.wire.view import Formation


class Memory:
    """What it has seen as leader, and what other leaders have handed over."""

    def __init__(self, mission: Mission) -> None:
        self._mission = mission
        self._leader: Leader | None = None
        self._handed = b""  # another robot's hits, unpacked only when needed
        self._handover = Handover(number=0, steps=0, seen=b"")
        self._no_way_at: Floats | None = None
        """Where it first knew no way on; none: another robot has led since."""
        self.no_way_since_s = math.inf
        """When that was, in this strand or a former one."""

    @property
    def number(self) -> int:
        """Counts the maps of leaders: the number of the newest that this robot has."""
        return self._handover.number

    @property
    def steps(self) -> int:
        """Switching steps that the fleet has planned so far, as far as this robot knows."""
        return max(self._handover.steps, 0 if self._leader is None else self._leader.steps)

    @property
    def seen(self) -> bytes:
        """The hits in the newest map, for another robot."""
        return self._handed or (b"" if self._leader is None else self._leader.map.packed())

    @property
    def handover(self) -> Handover:
        """The newest hand-over by a leader, this robot or another."""
        return self._handover

    @property
    def onward(self) -> Sequence[Place]:
        """The way on from the end of the newest step, as its map shows it."""
        return () if self._leader is None else self._leader.onward

    def take(self, formation: Formation) -> None:
        """Take in what a formation tells, unless this robot has a newer map; refused spots open again."""
        steps = max(self.steps, formation.counters.steps)
        if formation.seen is not None and formation.map_number > self.number:
            self._handed = formation.seen
            self._handover = Handover(number=formation.map_number, steps=steps, seen=formation.seen)
        else:
            self._handover = replace(self._handover, steps=steps)
        if formation.rank > 0:
            self._no_way_at = None
        if self._leader is not None:
            self._leader.map.reopen()
            if formation.rank > 0:
                self._leader.release()

    def note_no_way(self, here: Floats, now_s: float, *, anew: bool = False) -> None:
        """As leader it knows no way on; short steps round here are no way.

        A body behind that plugs the way is at most a link away, so further off it has got away. `anew`: it
        has handed on the lead and has it again, so nothing of before counts.
        """
        at = self._no_way_at
        if anew or at is None or math.dist(at, here) > self._mission.link_length_m_max:
            self._no_way_at, self.no_way_since_s = here, now_s

    def succeed(self, handover: Handover) -> None:
        """Take in a hand-over from the robot ahead, if it is newer."""
        if handover.number > self.number:
            self._handover, self._handed = handover, handover.seen

    def hand_on(self, acknowledged: int) -> None:
        """Make a new hand-over as leader, newer than any that robots behind have acknowledged."""
        assert self._leader is not None, "only a leader hands over"
        number = one_more(max(self.number, acknowledged))
        self._handover = Handover(number=number, steps=self.steps, seen=self.seen)

    def leader(self, here: Pose) -> Leader:
        """The leader of this robot, with everything that was handed over."""
        if self._leader is None:
            self._leader = Leader(self._mission, here)
        self._leader.count_on(self._handover.steps)
        if self._handed:
            self._leader.map.unpack(self._handed)
            self._handed = b""
        return self._leader
