"""Looking while driving, where obstacles move: how long the newest scan is good for.

Rule 1: no obstacle is faster than the mission says. So at any time after a scan, all that it showed, and
        whatever may hide where it showed nothing, is no nearer than that speed allows.
Rule 2: a motion is good until some time when the hull, anywhere that it may be by then, keeps off all that.
        Beyond, the body stands, whether or not its robot is heard: no robot is in contact while it moves.
"""

import numpy as np

from agents.certificate import scan_walls
from agents.scan import View
from protocol.arrays import Flags, Floats, segments_apart
from protocol.mission import WATCH_S, Mission

HORIZONS_S = (4.0 * WATCH_S, 2.0 * WATCH_S, WATCH_S, WATCH_S / 2.0)  # tried, longest first; one suffices


def good_for_s(view: View, target: Floats, robots: Flags, mission: Mission) -> float:
    """How long after the scan was taken a robot may go on driving to its target [s]; 0: not at all.

    Args:
        view: a scan taken on the way.
        target: where the robot drives to, straight (2,) [m; world frame].
        robots: which directions of the scan hit robots of the strand: kept from otherwise.
        mission: the robot's.
    """
    walls = scan_walls(view, mission, leave_out=robots)
    hull_m = walls.keep_m - mission.berth_m + mission.robot_radius_m + mission.mu0_m
    off = target - view.position
    length_m = float(np.hypot(*off))
    for horizon_s in HORIZONS_S:
        share = min(1.0, mission.speed_mps * horizon_s / length_m) if length_m > 0.0 else 0.0
        end = view.position + share * off
        apart_m = segments_apart(view.position, end, walls.starts, walls.ends)
        if (apart_m >= hull_m + mission.obstacle_speed_mps_max * horizon_s).all():
            return horizon_s
    return 0.0
