"""How far live strands have come, from their timelines while they are written. Pure.

Rule 1: the times are those of the machine's clock, as the entries tell them.
"""

from collections.abc import Iterable, Sequence

import msgspec
from msgspec import Struct

NTP64_PER_S = 2**32


class _Head(Struct):
    t_s: float
    hlc: str = ""
    kind: str = ""

    @property
    def wall_s(self) -> float:
        return int(self.hlc.partition("/")[0] or 0) / NTP64_PER_S


class Progress:
    """How far a run has come, from the bytes of its timeline as they are written."""

    def __init__(self, robots: int) -> None:
        self._robots = robots
        self._rest = b""
        self.now_s = 0.0
        """Simulated time of the newest entry."""
        self.ready_at_s: float | None = None
        """When the bodies were placed [s since 1970]."""
        self.formed_at_s: float | None = None
        """When the last robot joined the first strand [s since 1970]."""
        self.formed_s: float | None = None
        """The same in simulated time."""
        self.is_over = False
        """Whether robots have begun to tell their last counts."""
        self._joined = 0

    def read(self, piece: bytes) -> None:
        """Take in more of the timeline."""
        *lines, self._rest = (self._rest + piece).split(b"\n")
        for line in lines:
            if b'"kind":"strand.joined"' in line:
                self._join(msgspec.json.decode(line, type=_Head))
            elif b'"kind":"robot.settled"' in line:
                self.is_over = True
            elif self.ready_at_s is None and b'"kind":"pose.sampled"' in line:
                self.ready_at_s = msgspec.json.decode(line, type=_Head).wall_s
        if lines:
            self.now_s = max(self.now_s, msgspec.json.decode(lines[-1], type=_Head).t_s)

    def has_formed(self, times: int = 1) -> bool:
        """Whether all robots have joined so often."""
        return self._joined >= times * self._robots

    def _join(self, entry: _Head) -> None:
        self._joined += 1
        if self._joined == self._robots:
            self.formed_at_s, self.formed_s = entry.wall_s, entry.t_s


class Together:
    """How far all strands of a run have come."""

    def __init__(self, strands: Sequence[Progress]) -> None:
        self._strands = strands

    @property
    def now_s(self) -> float:
        """Simulated time of the newest entry, in the strand that is the last to write one."""
        return min(each.now_s for each in self._strands)

    @property
    def ready_at_s(self) -> float | None:
        """When the bodies of the last strand were placed [s since 1970]."""
        return _last(each.ready_at_s for each in self._strands)

    @property
    def formed_at_s(self) -> float | None:
        """When the last robot joined the first strand of its fleet [s since 1970]."""
        return _last(each.formed_at_s for each in self._strands)

    @property
    def formed_s(self) -> float | None:
        """The same in simulated time."""
        return _last(each.formed_s for each in self._strands)

    @property
    def is_over(self) -> bool:
        """Whether robots have begun to tell their last counts, in all strands."""
        return all(each.is_over for each in self._strands)

    def has_formed(self, times: int = 1) -> bool:
        """Whether all robots of each strand have joined one so often."""
        return all(each.has_formed(times) for each in self._strands)


def _last(times_s: Iterable[float | None]) -> float | None:
    known = list(times_s)
    return None if None in known else max(each for each in known if each is not None)
