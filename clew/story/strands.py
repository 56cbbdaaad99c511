"""The strand through time: its order and its path in each epoch. Pure.

Rule 1: a strand is there from when the fence lets it drive: `clew/story/forming.py`.
Rule 2: paths are made as S3 is judged: `world.judge.rules.paths`.
"""

from dataclasses import dataclass, field

from clew.story import forming
from clew.story.forming import Forming, Strand
from protocol.keys import robot_number
from protocol.path import Path
from protocol.timeline import Entry, StepAbandoned, StepPlanned, StrandFormed
from world.judge.rules.paths import Paths

LAYING = frozenset({StepPlanned, StepAbandoned, StrandFormed})
"""What a path depends on."""
KINDS = LAYING | forming.KINDS


@dataclass(slots=True)
class Strands:
    """Orders and paths, as entries tell of them."""

    formed: dict[int, Strand] = field(default_factory=dict)
    """By epoch, in the order in which they were heard of."""
    laid_count: int = 0
    """How many entries have been heard on which a path depends."""
    _paths: Paths = field(default_factory=Paths)
    _forming: Forming = field(default_factory=Forming)

    def hear(self, source: str, entry: Entry) -> None:
        """Take an entry in."""
        if (strand := self._forming.hear(entry)) is not None:
            self.formed[strand.formed.epoch] = strand
        if type(entry.record) in LAYING and (robot := robot_number(source)) is not None:
            self._paths.hear(robot, entry.t_s, entry.record)
            self.laid_count += 1

    def paths(self) -> dict[int, Path]:
        """The path of every strand that has formed."""
        found = {epoch: self._paths.of(strand.formed) for epoch, strand in self.formed.items()}
        return {epoch: path for epoch, path in found.items() if path is not None}
