"""A switching step: what of it a scan shows, and the certified steps among which one is chosen."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from agents.navigation.certificate import Walls, certified_lengths_m
from agents.navigation.gaps import Gap, find_gaps, is_passable
from agents.navigation.guidance import CostToGo
from agents.navigation.headings import may_cost_less
from agents.navigation.obstacles import Obstacle, find_obstacles, passable_width_m
from agents.navigation.scan import View
from protocol.arrays import Floats, Indices, unit_vectors
from protocol.frames import wrap
from protocol.mission import Mission

HEADINGS = 360  # one per degree: 7 cm apart at 4 m, finer than any gap that admits a robot
LENGTHS = 32  # end points tried along each heading
GAIN_M = 0.01  # a step that shortens the way by less is not worth a stop
WAY_CELLS = 64  # cells of guidance's way that are tried, too: in narrow ground a degree is too coarse
FIRST_OF = 8  # cells of that way per sample: it tells which of the other headings are worth a try


@dataclass(frozen=True)
class Sight:
    """The obstacles and gaps that the leader finds in a scan."""

    view: View
    obstacles: Sequence[Obstacle]
    gaps: Sequence[Gap]
    passable_m: float

    @property
    def passable_gaps(self) -> list[int]:
        """Indices of the gaps that can be passed (9)."""
        return [i for i, gap in enumerate(self.gaps) if is_passable(gap, passable_m=self.passable_m)]

    @property
    def widest_gap(self) -> int | None:
        """Index of the widest passable gap (10)."""
        return max(self.passable_gaps, key=lambda index: self.gaps[index].width_m, default=None)


@dataclass(frozen=True)
class Step:
    """A straight move."""

    heading_rad: float
    length_m: float
    gap: int | None = None
    cost_to_go_m: float | None = None

    def target(self, origin: Floats) -> Floats:
        """The next switching position (2,) [m; world frame]."""
        heading = np.array([np.cos(self.heading_rad), np.sin(self.heading_rad)])
        return np.asarray(origin + self.length_m * heading)


@dataclass(frozen=True)
class NoStep:
    """There is no step, with the reason."""

    reason: str


@dataclass(frozen=True)
class LookCloser:
    """The scan has too few rays to decide."""


@dataclass(frozen=True)
class Crossed:
    """Without a goal: no gap is left ahead, so the region has been crossed."""


def look(view: View, mission: Mission) -> Sight:
    """Find obstacles and gaps in a scan."""
    passable_m = passable_width_m(mission.obstacle_keep_m)
    obstacles = find_obstacles(view, passable_m=passable_m)
    return Sight(view, tuple(obstacles), tuple(find_gaps(obstacles)), passable_m)


def certified_step_to_goal(view: View, walls: Walls, cost_to_go: CostToGo) -> Step | None:
    """The certified step with the least cost-to-go; None if no certified step comes nearer.

    The walls are those of the scan, and maybe more.
    """
    step = _best_step(view, walls, cost_to_go)
    here_m = float(cost_to_go.at(view.position[None, :])[0])
    return step if step.cost_to_go_m is not None and step.cost_to_go_m < here_m - GAIN_M else None


def has_way(view: View, walls: Walls, cost_to_go: CostToGo, *, none_nearer: bool = False) -> bool:
    """Whether there is a way from here, or from the end of a certified step.

    `none_nearer`: `certified_step_to_goal` has found no step that ends nearer to the goal. Then no step ends
    where there is a way unless there is one from here: such an end would be nearer.
    """
    here_m = float(cost_to_go.at(view.position[None, :])[0])
    if here_m < np.inf or none_nearer:
        return here_m < np.inf
    return _best_step(view, walls, cost_to_go).cost_to_go_m is not None


def _best_step(view: View, walls: Walls, cost_to_go: CostToGo) -> Step:
    """The certified step with the least cost-to-go; its cost is None if no end point has a way."""
    way = cost_to_go.way_from(view.position, cells_max=WAY_CELLS)
    headings = _headings(_bearings_rad(way, view.position))
    tried, costs = np.zeros((len(headings), LENGTHS)), np.full((len(headings), LENGTHS), np.inf)

    def rank(some: Indices, least_m: float = 0.0) -> None:
        tried[some] = lengths_m = _tried(_certified_m(view, walls, headings[some]))
        heading, length = np.nonzero(lengths_m >= least_m)
        directions = unit_vectors(headings[some])[heading]
        ends = view.position + lengths_m[heading, length, None] * directions
        costs[some[heading], length] = cost_to_go.at(ends)

    first = np.arange(0, len(way), FIRST_OF)
    rank(first)
    others, least_m = may_cost_less(view, headings, cost_to_go, float(costs.min()))
    others[first] = False
    rank(np.flatnonzero(others), least_m)
    best = np.unravel_index(np.argmin(costs), costs.shape)
    cost_m = float(costs[best]) if costs[best] < np.inf else None
    return Step(wrap(float(headings[best[0]])), float(tried[best]), cost_to_go_m=cost_m)


def certified_step_to(view: View, walls: Walls, goal: Floats) -> Step | None:
    """The step to the goal, if it is certified."""
    off_goal = goal - view.position
    goal_m, goal_rad = float(np.hypot(*off_goal)), float(np.arctan2(off_goal[1], off_goal[0]))
    if goal_m > float(view.ranges_m.max()):
        return None
    if goal_m > certified_lengths_m(view.position, np.array([goal_rad]), walls)[0]:
        return None
    return Step(goal_rad, goal_m, cost_to_go_m=0.0)


def refused_at(view: View, walls: Walls, way: Floats) -> int:
    """Index of the first point of a way (n, 2) that no certified step reaches; n if all are reached."""
    if len(way) == 0:
        return 0
    free_m = certified_lengths_m(view.position, _bearings_rad(way, view.position), walls)
    refused = np.flatnonzero(np.hypot(*(way - view.position).T) > free_m)
    return int(refused[0]) if len(refused) else len(way)


def _bearings_rad(points: Floats, origin: Floats) -> Floats:
    off = points - origin
    return np.asarray(np.arctan2(off[:, 1], off[:, 0]))


def certified_step_through(sight: Sight, walls: Walls, *, onward_rad: float) -> Step | None:
    """Without a goal: a step towards the widest passable gap ahead that a certified step can approach.

    The end point is the one nearest to the gap's middle. If no step comes nearer to a gap, the next widest is
    tried. "Onward" is the leader's first heading; it does not go back to gaps behind.
    """
    ahead = sorted(gaps_ahead(sight, onward_rad), key=lambda index: -sight.gaps[index].width_m)
    steps = (_step_towards(sight, walls, index) for index in ahead)
    return next((step for step in steps if step is not None), None)


def certified_step_onward(sight: Sight, walls: Walls, *, onward_rad: float) -> Step | None:
    """The step that gains most onward; None if none gains enough."""
    headings = _headings(np.array([onward_rad]))
    lengths = _certified_m(sight.view, walls, headings)
    gained_m = lengths * (np.cos(headings - onward_rad))
    best = int(np.argmax(gained_m))
    return Step(wrap(float(headings[best])), float(lengths[best])) if gained_m[best] >= GAIN_M else None


def gaps_ahead(sight: Sight, onward_rad: float) -> list[int]:
    """Indices of the passable gaps that are at most a right angle off the onward direction."""
    return [index for index in sight.passable_gaps if _opens_ahead(sight, index, onward_rad)]


def is_open(sight: Sight, onward_rad: float) -> bool:
    """Whether nothing in sight is in the robot's way in this direction."""
    onward = np.array([np.cos(onward_rad), np.sin(onward_rad)])
    off = sight.view.hit_points - sight.view.position
    along, beside = off @ onward, np.abs(off @ np.array([-onward[1], onward[0]]))
    return not bool(((along > 0.0) & (beside < sight.passable_m / 2.0)).any())


def _opens_ahead(sight: Sight, index: int, onward_rad: float) -> bool:
    """Whether a gap is at most a right angle off the onward direction.

    A gap whose middle is nearer than the robot's own clearance is not ahead: the robot stands in it.
    """
    gap = sight.gaps[index]
    off = gap.middle - sight.view.position
    turn_rad = wrap(float(np.arctan2(off[1], off[0])) - onward_rad)
    stands_in_it = float(np.hypot(*off)) < sight.passable_m / 2.0
    return abs(turn_rad) <= np.pi / 2.0 and not stands_in_it


def _step_towards(sight: Sight, walls: Walls, index: int) -> Step | None:
    middle, origin = sight.gaps[index].middle, sight.view.position
    off = middle - origin
    headings = _headings(np.array([np.arctan2(off[1], off[0])]))
    tried = _tried(_certified_m(sight.view, walls, headings))
    short_m = np.hypot(*np.moveaxis(_ends(origin, headings, tried) - middle, -1, 0))
    best = np.unravel_index(np.argmin(short_m), short_m.shape)
    if not short_m[best] < np.hypot(*off) - GAIN_M:
        return None
    return Step(wrap(float(headings[best[0]])), float(tried[best]), gap=index)


def _headings(preferred_rad: Floats) -> Floats:
    """The headings that are tried, preferred ones first."""
    even = -np.pi + 2.0 * np.pi * np.arange(HEADINGS) / HEADINGS
    return np.concatenate([preferred_rad, even])


def _certified_m(view: View, walls: Walls, headings_rad: Floats) -> Floats:
    """The longest certified step in each heading (h,) within the seen range."""
    lengths_m = certified_lengths_m(view.position, headings_rad, walls)
    return np.minimum(lengths_m, float(view.ranges_m.max()))


def _tried(lengths_m: Floats) -> Floats:
    """The lengths (h, LENGTHS) at which an end point is tried, up to these (h,)."""
    return np.asarray(lengths_m[:, None] * np.arange(1, LENGTHS + 1) / LENGTHS)


def _ends(origin: Floats, headings_rad: Floats, lengths_m: Floats) -> Floats:
    """End points (h, k, 2) of steps with these lengths (h, k) in each heading."""
    directions = unit_vectors(headings_rad)
    return np.asarray(origin + lengths_m[:, :, None] * directions[:, None, :])
