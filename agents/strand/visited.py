"""The places that a leader has planned from in one epoch, and its scans from there. Pure.

Rule 1: planning from one place again and again counts as wandering.
Rule 2: where nothing but the strand moves, scans from other places narrow what the closest look may have
        missed. In another epoch bodies may have moved (F6 of docs/strand.md).
"""

import math
from dataclasses import replace

from agents.navigation.scan import View
from protocol.arrays import Floats

EARLIER_MAX = 8  # scans of other places that are kept: some metres of a narrow way
AGAIN_MAX = 12  # ten steps of `GAIN_M` leave the place; sound leaders plan at most 4 times from one place


class Visited:
    """What a leader keeps within one epoch."""

    def __init__(self, epoch: int = 0) -> None:
        self.epoch = epoch
        self._places: list[Floats] = []
        self._scans: tuple[View, ...] = ()
        """The newest, one a place."""

    def narrow(self, view: View, *, is_closest: bool) -> View:
        """Keep a scan; the closest one is narrowed by those from other places (rule 2)."""
        others = tuple(each for each in self._scans if (each.position != view.position).any())
        self._scans = (*others[-EARLIER_MAX:], view)
        return replace(view, earlier=others) if is_closest else view

    def too_often(self, here: Floats, *, near_m: float) -> bool:
        """Whether there were too many plans from here (rule 1). If not, the place is noted."""
        if sum(math.dist(here, place) <= near_m for place in self._places) >= AGAIN_MAX:
            return True
        self._places.append(here)
        return False
