"""All bodies of a fleet, and what they do in a tick.

Rule 1: a tick costs nothing for a body at rest, and a scan does not ask where all bodies are while they rest.
"""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from protocol.arrays import Flags, Floats
from protocol.fence import Fence
from protocol.frames import Pose
from protocol.wire.messages import Drive
from world.bodies.body import Body
from world.scenario.sections import DriveSection


class Start(NamedTuple):
    """Where a body was before a tick [m, rad; world frame]."""

    x_m: float
    y_m: float
    heading_rad: float


class Moves(NamedTuple):
    """What all bodies did in one tick; bodies are given by index, in order."""

    starts: dict[int, Start]
    """Of the bodies that were not at rest; each moved straight at constant speed to where it is now."""
    veered: list[int]
    """The bodies that move differently than in the tick before."""
    finished: list[int]
    stopped: list[int]
    """The bodies that the dead-man stop has stopped on their way."""


class Bodies:
    """The poses of all bodies, and their present orders."""

    def __init__(
        self, starts: Sequence[Pose], limits: DriveSection, errors: Sequence[np.random.Generator]
    ) -> None:
        """One random stream per body: the order of arrival must not matter."""
        self._bodies = [
            Body(row + 1, start, limits, stream)
            for row, (start, stream) in enumerate(zip(starts, errors, strict=True))
        ]
        self._place_m: Floats | None = None
        """Where they are, once it has been asked; None: since then one has moved."""

    def __len__(self) -> int:
        return len(self._bodies)

    def __getitem__(self, body: int) -> Body:
        return self._bodies[body]

    @property
    def place_m(self) -> Floats:
        """(N, 2) [world frame]; a new array."""
        if self._place_m is None:
            self._place_m = np.array(self.places).reshape(-1, 2)
        return self._place_m.copy()

    @property
    def places(self) -> list[tuple[float, float]]:
        """The same as pairs."""
        return [(body.x_m, body.y_m) for body in self._bodies]

    @property
    def moving(self) -> Flags:
        """The bodies that turn or drive."""
        return np.array([body.moves for body in self._bodies])

    @property
    def movers(self) -> list[int]:
        """The same by index."""
        return [row for row, body in enumerate(self._bodies) if body.moves]

    @property
    def any_moves(self) -> bool:
        """Whether any body turns or drives."""
        return any(body.moves for body in self._bodies)

    def is_moving(self, body: int) -> bool:
        """Whether a body turns or drives."""
        return self._bodies[body].moves

    def pose(self, body: int) -> Pose:
        """The pose of a body [world frame]."""
        at = self._bodies[body]
        return Pose(x_m=at.x_m, y_m=at.y_m, heading_rad=at.heading_rad)

    @property
    def orders(self) -> list[Drive | None]:
        """The order that each body has in hand, or the last one that it has finished under the fence."""
        return [body.order for body in self._bodies]

    @property
    def courses_m(self) -> Floats:
        """(N, 4) [world frame]: from x, y to x, y, the straight course of each body."""
        return np.array([body.course_m for body in self._bodies])

    def basis_s(self, body: int) -> float:
        """When the body's robot was last known to be awake: the basis of its newest order."""
        return self._bodies[body].basis_s

    def resume(self, body: int, pose: Pose, *, ordered: int, finished: int, now_s: float) -> None:
        """Stand at this pose without an order in hand."""
        self._place_m = None
        self._bodies[body].resume(pose, ordered=ordered, finished=finished, now_s=now_s)

    def stand(self) -> None:
        """Stop all bodies and drop their orders: the fence changes, or the run is over."""
        for body in self._bodies:
            body.stand()

    def hear(self, body: int, drive: Drive, fence: Fence, *, now_s: float) -> bool:
        """Process an order under this fence; returns whether it is new.

        Raises:
            MessageRefusedError: the order is void, or the drive cannot execute it.
        """
        return self._bodies[body].hear(drive, fence, now_s=now_s)

    def tick(self, *, now_s: float, tick_s: float) -> Moves:
        """Move all bodies for one tick from `now_s` on."""
        starts: dict[int, Start] = {}
        veered: list[int] = []
        finished: list[int] = []
        stopped: list[int] = []
        for row, body in enumerate(self._bodies):
            if body.is_at_rest:
                continue
            starts[row] = Start(body.x_m, body.y_m, body.heading_rad)
            news = body.tick(now_s=now_s, tick_s=tick_s)
            if news.veered:
                veered.append(row)
            if news.finished:
                finished.append(row)
            if news.stopped:
                stopped.append(row)
        if starts:
            self._place_m = None
        return Moves(starts, veered, finished, stopped)
