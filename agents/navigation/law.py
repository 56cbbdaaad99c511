"""What a law is: it proposes a switching step from what the leader sees and remembers. docs/laws.md.

Rule 1: a law is a pure function of `Seen`: the same sight, the same answer, in a run and in its replay.
        Chance comes from `Seen.seed`.
Rule 2: a law only proposes. The step is shortened to what is certified, or refused (`asked`), and the
        certificate is of the scan itself: a law of a user is given copies, and may change them.
Rule 3: a law that fails, or proposes no straight step, is refused like one that proposes nothing.
"""

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from enum import Enum, auto
from functools import cached_property
from hashlib import blake2b
from types import FrameType
from typing import Protocol

import numpy as np

from agents.navigation.certificate import Walls, certified_lengths_m
from agents.navigation.gaps import Gap
from agents.navigation.guidance import CostToGo
from agents.navigation.obstacles import Obstacle
from agents.navigation.scan import fix
from agents.navigation.step import GAIN_M, Sight, Step
from protocol import laws
from protocol.arrays import Floats, xy
from protocol.errors import is_failure, recordable, sentence_of
from protocol.frames import wrap
from protocol.laws import OURS, register
from protocol.mission import Mission

ROUNDING_M = 1e-9  # a law's own search for certified steps may differ from the check by the last bit


@dataclass(frozen=True)
class Seen:
    """What a law gets; positions are in the frame of odometry, which all robots share [m, rad]."""

    sight: Sight
    walls: Walls
    mission: Mission
    """What the robot knows before it starts: its size, `epsilon_m`, `range_m_max`, `bounds` and so on."""
    onward_rad: float
    """The heading of this robot when it led first: where to go without a goal."""
    steps: int
    """Switching steps that the fleet has planned so far."""
    remembered: Floats
    """All hits in the leader's map (n, 2), also of leaders before it; none without a goal."""
    path: Floats
    """The corners (n, 2) of the strand's path, from its last robot's place when it formed to the leader.

    It is as planned: bodies keep to it within `mission.mu0_m`.
    """
    ways: Callable[[], CostToGo] | None = None
    """The cost-to-go by what is remembered; None without a goal."""

    def __post_init__(self) -> None:
        fix(self.remembered, self.path, self.walls.starts, self.walls.ends, self.walls.keep_m)

    def __repr__(self) -> str:
        goal = "no goal" if self.goal is None else "goal ({:.3f}, {:.3f})".format(*self.goal)
        return (
            f"<clew.Seen from ({self.position[0]:.3f}, {self.position[1]:.3f}), {goal}: "
            f"{len(self.ranges_m)} rays, {len(self.hits)} hits, {len(self.obstacles)} obstacles, "
            f"{self.steps} steps planned before>"
        )

    @property
    def position(self) -> Floats:
        """Where the leader stands (2,)."""
        return self.sight.view.position

    @cached_property
    def goal(self) -> Floats | None:
        """The goal (2,), if there is one."""
        return None if self.mission.goal is None else xy(self.mission.goal)

    @property
    def bearings_rad(self) -> Floats:
        """The directions of the scan, anti-clockwise from -pi (n,)."""
        return self.sight.view.bearings_rad

    @property
    def ranges_m(self) -> Floats:
        """How far the scan saw in each direction (n,), at most `mission.range_m_max`."""
        return self.sight.view.ranges_m

    @property
    def hits(self) -> Floats:
        """Where rays met something (k, 2); with a goal without the robots of the strand."""
        return self.sight.view.hit_points

    @property
    def obstacles(self) -> Sequence[Obstacle]:
        """Runs of hits that nothing can pass between, anti-clockwise."""
        return self.sight.obstacles

    @property
    def gaps(self) -> Sequence[Gap]:
        """The openings between neighbouring obstacles; `gap.middle`, `gap.width_m`."""
        return self.sight.gaps

    def copied(self) -> "Seen":
        """The same with copies of the scan and the walls, which decide what is certified (rule 2)."""
        sight = replace(self.sight, view=self.sight.view.copied())
        return replace(self, sight=sight, walls=Walls.joined(self.walls))

    @property
    def seed(self) -> int:
        """For random draws: a number that every scan and every step changes."""
        said = self.ranges_m.tobytes() + self.position.tobytes() + self.steps.to_bytes(8, "big")
        return int.from_bytes(blake2b(said, digest_size=8).digest(), "big")

    def free_m(self, bearings_rad: Floats | Sequence[float]) -> Floats:
        """The longest certified step in each direction (n,)."""
        lengths_m = certified_lengths_m(self.position, np.asarray(bearings_rad, dtype=float), self.walls)
        return np.minimum(lengths_m, float(self.ranges_m.max()))

    def cost_to_go_m(self, points: Floats) -> Floats:
        """The cost of the way from each point (n, 2) to the goal; infinite where there is none."""
        points = np.asarray(points, dtype=float)
        return np.full(len(points), np.inf) if self.ways is None else self.ways().at(points)

    def step_to(self, place: Floats | Sequence[float]) -> Step:
        """The straight step to a place (2,)."""
        x_m, y_m = np.asarray(place, dtype=float) - self.position
        return Step(math.atan2(y_m, x_m), math.hypot(x_m, y_m))


class Law(Protocol):
    """Proposes a switching step from what is seen and remembered."""

    def __call__(self, seen: Seen, /) -> Step | str | None:
        """The step to propose; or None: no opening from here; or in words why there is none."""
        ...


def register_law(name: str, law: Law) -> None:
    """Add a law to this process by name, or replace one; `clew.rehearse(..., law=name)` finds it.

    Raises:
        UsageError: the name is one of Clew's, or no name of a law; or the law cannot be called.
    """
    register(name, law)


class Why(Enum):
    """Why there is no step."""

    NOTHING = auto()
    """The law proposes none."""
    UNCERTIFIED = auto()
    """No part of it is certified."""
    FAILED = auto()
    """The law has failed: to ask it again is of no use."""


@dataclass(frozen=True)
class Refused:
    """A law has been asked in vain."""

    why: Why
    reason: str


def asked(law: Law, seen: Seen) -> Step | Refused:
    """What a law proposes, as far as it may be driven (rules 2 and 3)."""
    name = seen.mission.law
    try:
        said = law(seen if name in OURS else seen.copied())
        step = said if said is None or isinstance(said, str) else _whole(said, gaps=len(seen.gaps))
    except BaseException as error:  # rule 3: the law is the user's
        if not is_failure(error):
            raise
        why = sentence_of(error, through={__file__, laws.__file__})
        return Refused(Why.FAILED, recordable(f"the law {name} failed: {why}"))
    if step is None or isinstance(step, str) or step.length_m == 0.0:
        step = step if isinstance(step, str) else None
        why = step or f"the law {name} proposes no step from here"
        return Refused(Why.NOTHING, recordable(why))
    return _certified(step, seen) if seen.mission.promises_clearance else step


def call_in(frame: FrameType | None) -> FrameType | None:
    """The call of `asked`, for a law of a user, in which this frame runs; None: there is none."""
    while frame is not None:
        if frame.f_code is asked.__code__ and frame.f_locals["name"] not in OURS:
            return frame
        frame = frame.f_back
    return None


def _whole(step: object, *, gaps: int) -> Step:
    """The step with plain numbers.

    Raises:
        ValueError: it is no straight step.
        TypeError: it is no step, or has something else for a number.
    """
    if not isinstance(step, Step):
        raise TypeError(f"it proposes no step but {type(step).__name__}")
    # Plain before they are checked: what a law takes for a number may be another one when it is read again.
    heading_rad, length_m = float(step.heading_rad), float(step.length_m)
    gap = None if step.gap is None else int(step.gap)
    cost_m = None if step.cost_to_go_m is None else float(step.cost_to_go_m)
    if not math.isfinite(heading_rad) or not 0.0 <= length_m < math.inf:
        raise ValueError(f"a step needs a heading and a length, got {heading_rad} rad and {length_m} m")
    if gap not in {None, *range(gaps)} or not 0.0 <= (cost_m or 0.0) < math.inf:
        raise ValueError(f"a step has no gap {gap} of {gaps}, or no cost {cost_m}")
    return Step(wrap(heading_rad), length_m, gap, cost_m)


def _certified(step: Step, seen: Seen) -> Step | Refused:
    """The part of a step that is certified."""
    free_m = float(seen.free_m([step.heading_rad])[0])
    tells_gain = step.cost_to_go_m is not None  # near something a short step may gain more than its length
    if step.length_m <= free_m + ROUNDING_M and (tells_gain or free_m >= GAIN_M):
        return step
    if free_m < GAIN_M:  # also where the law has shortened it: only a refusal leads to a closer look
        return Refused(
            Why.UNCERTIFIED,
            f"the law {seen.mission.law} proposes {step.length_m:.3f} m at {step.heading_rad:.3f} rad, "
            f"of which {free_m:.4f} m are certified",
        )
    return replace(step, length_m=free_m, cost_to_go_m=None)
