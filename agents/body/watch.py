"""Scans while driving, where obstacles move: decides how long the newest scan permits the motion.

Rule 1: no obstacle is faster than the mission says. So at any time after a scan, everything that it showed,
        and anything hidden beyond, is no nearer than that speed allows. Robots of the own strand are no
        exception: something may come out from behind them.
Rule 2: a motion is permitted for as long as the hull, wherever it may be by then, keeps off all of that.
        After that time the body stops by itself, so no robot is in contact while it moves.
Rule 3 (liveness): a motion towards something must be permitted for a while, and ends a moment before that may
        be met: nearer, neither of two robots could get away from the other. Or it must pass all that is seen,
        as it stands, with a moment to spare: it costs the time in which the robot stands between two moments.
        What was planned for `BRIEF_S` is seen some millimetres nearer on the way, so `MOVES_S` are enough.
Rule 4: a driving robot asks for a scan at every odometry, whether it follows, leads or joins.
"""

import math

import numpy as np

from agents.body.driver import Driver
from agents.body.senses import Senses
from agents.commands import Command
from agents.navigation.certificate import scan_walls
from agents.navigation.scan import View
from protocol.arrays import Flags, Floats, distances_to_segments, segments_apart
from protocol.frames import Pose
from protocol.mission import BRIEF_S, MOVES_S, WATCH_S, Mission
from protocol.sweep import TOUCHING_M

LONGEST_S = 4.0 * WATCH_S  # of a permission
TIMES_S = LONGEST_S * np.arange(1, 129) / 128  # to a hundredth of a second
APPROACH_S = WATCH_S / 2.0  # a motion towards something must be safe for so long
LEAST_S = 0.04  # two of the world's ticks: order, and one to move in
GIVE_UP_S = 2.0  # without permission: a pedestrian has passed by then
STILL_S_MAX = 10.0  # a body with permission stands less, even with 30 % loss and 0.5 s delay of all messages


class Watch:
    """The newest scan of a driving robot, and what it permits."""

    def __init__(self, mission: Mission, driver: Driver, senses: Senses) -> None:
        self._mission = mission
        self._driver = driver
        self._senses = senses
        self.still_since_s = math.inf
        """Since when the body has not moved while under way, without the time in which it had to stand.

        A scan that arrives too late permits nothing, either.
        """
        self._still_s = self._noted_s = 0.0
        self._unsure_since_s = math.inf  # since when the newest scans have permitted nothing
        self._pose: Pose | None = None
        self._looked_at_s = 0.0

    def look(self, now_s: float) -> list[Command]:
        """Permit the motion for as long as the newest scan allows, and ask for the next scan."""
        driver = self._driver
        if not self._mission.obstacles_move or driver.standing or driver.drive.target is None:
            self.still_since_s = self._unsure_since_s = math.inf
            self._noted_s = now_s
            return []
        moves, self._pose = driver.odometry.pose != self._pose, driver.odometry.pose
        self._still_s = 0.0 if moves else self._still_s + now_s - self._noted_s
        self._noted_s = now_s
        self.still_since_s = math.inf if moves else now_s - self._still_s
        glimpse = self._senses.glimpse(driver.ordered_s)
        if glimpse is not None:
            seen, taken_at_s = glimpse
            target = np.array([driver.drive.target.x_m, driver.drive.target.y_m])
            good_s = good_for_s(seen, target, self._mission)
            driver.permit(taken_at_s + good_s)
            self._unsure_since_s = math.inf if good_s > 0.0 else min(self._unsure_since_s, now_s)
        if driver.odometry.t_s <= self._looked_at_s:
            return []
        self._looked_at_s = driver.odometry.t_s
        return self._senses.look(now_s)

    def gives_up(self, now_s: float) -> bool:
        """Whether to give up the current step."""
        return now_s - self._unsure_since_s > GIVE_UP_S or now_s - self.still_since_s > STILL_S_MAX

    def begin_again(self) -> None:
        """The step has been given up: the count of still time starts again."""
        self._still_s = 0.0


def good_for_s(view: View, target: Floats, mission: Mission) -> float:
    """How long after the scan the robot may go on driving to its target [s]; 0: not at all.

    Args:
        view: a scan taken on the way.
        target: the target of the straight drive (2,) [m; world frame].
        mission: the robot's mission.
    """
    walls = scan_walls(view, mission)  # rule 1: no hit is left out
    speed_mps, hull_m = mission.obstacle_speed_mps_max, mission.robot_radius_m + mission.mu0_m
    off = target - view.position
    length_m = max(float(np.hypot(*off)), TOUCHING_M)
    here_m = distances_to_segments(view.position, walls.starts, walls.ends)
    to_target_m = segments_apart(view.position, target, walls.starts, walls.ends)
    leaves_no_moment = to_target_m < hull_m + speed_mps * MOVES_S
    in_way = leaves_no_moment & (to_target_m < here_m - TOUCHING_M)
    keep_m = hull_m + np.where(in_way, speed_mps * BRIEF_S, 0.0)

    def swept_m(for_s: Floats, near: Flags | slice) -> Floats:
        """The distances (..., k) from the ground swept until then to the walls that are near."""
        ends = view.position + np.minimum(1.0, mission.speed_mps * for_s / length_m)[..., None, None] * off
        return segments_apart(view.position, ends, walls.starts[near], walls.ends[near])

    # Nothing is in the way before both have driven towards each other; what would hit it here is by then.
    soonest_s = (here_m - keep_m) / (mission.speed_mps + speed_mps)
    first_s, last_s = (float(each.min(initial=np.inf)) for each in (soonest_s, (here_m - keep_m) / speed_mps))
    unsure_s, near = TIMES_S[(first_s < TIMES_S) & (last_s > TIMES_S)], soonest_s < last_s
    latest_s = unsure_s[-1:]  # what is not in the way by then is not in the way earlier
    near[near] = (swept_m(latest_s, near) < keep_m[near] + speed_mps * latest_s[:, None]).any(axis=0)
    good = len(unsure_s)
    if near.any():
        is_good = swept_m(unsure_s, near) >= keep_m[near] + speed_mps * unsure_s[:, None]
        good = int(is_good.all(axis=1).sum())
    good_s = LONGEST_S / len(TIMES_S) * float((first_s >= TIMES_S).sum() + good)
    if good_s < APPROACH_S:
        approach_m = swept_m(np.array(APPROACH_S), slice(None))
        approached = (approach_m < hull_m + speed_mps * APPROACH_S) & (approach_m < here_m - TOUCHING_M)
        if leaves_no_moment.any() and approached.any():
            return 0.0
    return good_s if good_s >= LEAST_S else 0.0
