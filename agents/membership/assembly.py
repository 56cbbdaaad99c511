"""The pieces of a formation, put together again by a member. Pure.

Rule 1: a member acts only when it has all pieces: a robot that grants or leads must know all ground behind
        it.
Rule 2: arc lengths are used as they are told, so that all members have the same ones.
Rule 3: it keeps as many pieces as the longest path has, so a coordinator that lies fills no memory.
"""

from collections.abc import Sequence

import numpy as np

from protocol.frames import VERTICES_MAX, Vertex
from protocol.path import THERE_M, Path
from protocol.wire.view import PIECE_VERTICES_MAX, Formation


class Assembly:
    """The pieces of one formation that a member has."""

    def __init__(self) -> None:
        self._pieces: dict[int, Formation] = {}

    def add(self, piece: Formation) -> None:
        """Take in a piece of this epoch's formation for this life: there is one (F4)."""
        if piece.first in range(0, VERTICES_MAX, PIECE_VERTICES_MAX):  # rule 3
            self._pieces[piece.first] = piece

    @property
    def whole(self) -> tuple[Formation, Path] | None:
        """The first piece and the whole path, when all pieces are there and their path is one."""
        vertices: list[Vertex] = []
        for first in sorted(self._pieces):
            if first != len(vertices):
                return None
            vertices += self._pieces[first].path
        if not vertices or len(vertices) != self._pieces[0].vertices or not is_path(vertices):
            return None
        return self._pieces[0], Path.told(vertices)


def is_path(vertices: Sequence[Vertex]) -> bool:
    """Whether arc lengths begin at 0 and equal the coordinates', up to rounding."""
    along = np.array([(vertex.x_m, vertex.y_m, vertex.s_m) for vertex in vertices])
    steps_m = np.hypot(*np.diff(along[:, :2], axis=0).T)
    off_m = np.abs(along[:, 2] - np.concatenate([[0.0], np.cumsum(steps_m)]))
    return bool(off_m.max() <= THERE_M * len(vertices))
