"""What a robot's scan shows of the leg to the robot ahead, while all robots stand. Pure."""

import numpy as np

from agents.navigation.leg import certain_clearance_m_min, leg_is_certain, leg_meets_nothing
from agents.navigation.scan import View, on_discs
from agents.navigation.sure import closer
from protocol.arrays import Flags, Floats, distances_to_segments
from protocol.legs import hull_hides
from protocol.mission import Mission
from protocol.sweep import TOUCHING_M


def without_hulls(view: View, robots: Floats, mission: Mission) -> View:
    """A scan without what it shows of robots that stand (n, 2)."""
    hulls = np.zeros(len(view.hits), dtype=np.bool_)
    hulls[view.hits] = on_discs(view.hit_points, robots, within_m=mission.hull_reach_m)
    return view.without(hulls, np.stack([robots, robots], axis=1))


def leg_is_clear(seen: View, ahead: Floats, mission: Mission) -> bool:
    """Whether the straight way to the robot ahead (2,) is, in a scan without hulls."""
    rays = len(seen.ranges_m)
    return _leg_may_be_clear(seen, ahead, mission, rays=rays) and leg_is_certain(seen, ahead, mission)


def leg_needs_closer_look(seen: View, ahead: Floats, mission: Mission) -> bool:
    """Of a leg that is not clear: whether only what the scan may have missed blocks it."""
    return (
        closer(mission, len(seen.ranges_m)) is not None
        and _leg_may_be_clear(seen, ahead, mission, rays=mission.closest_rays)
        and (leg_meets_nothing(seen, ahead, mission) or leg_is_certain(seen, ahead, mission))
    )


def _leg_may_be_clear(seen: View, ahead: Floats, mission: Mission, *, rays: int) -> bool:
    leg_m = float(np.hypot(*(ahead - seen.position)))
    if leg_m > mission.leg_m_max or hull_hides(leg_m, rays, mission):
        return False
    return not hides_way(seen, ahead, mission)


def hides_way(seen: View, ahead: Floats, mission: Mission) -> bool:
    """Whether a hull that was taken out of a scan stands on the way: the scan shows nothing behind it.

    The robot ahead apart, at whose place the way ends. What stands beside the way hides nothing on it; what
    may reach out of its shadow is for `agents.navigation.leg`, which takes what is nearer than that for the
    robot ahead. No hull is so near, but what moves and counts as one may be.
    """
    taken_out = seen.points[~seen.hits & (seen.ranges_m < mission.range_m_max)]
    hulls = taken_out[~on_discs(taken_out, ahead[None], within_m=mission.hull_reach_m)]
    on_way = distances_to_segments(hulls, seen.position, ahead) < mission.hull_reach_m
    return bool(on_way.any() or on_ways(hulls, seen.position[None], ahead, mission)[0])


def on_ways(hulls: Floats, places: Floats, ahead: Floats, mission: Mission, *, slack_m: float = 0.0) -> Flags:
    """Whether points of hulls (h, 2) lie on the straight way from each place (n, 2) to the robot ahead."""
    way = (ahead - places)[:, None]
    leg_m = np.hypot(way[..., 0], way[..., 1])
    along_m = ((hulls - places[:, None]) * way).sum(axis=-1) / np.maximum(leg_m, TOUCHING_M)
    on_way_m = distances_to_segments(hulls, places[:, None], np.broadcast_to(ahead, way.shape))
    needs_m = mission.robot_radius_m + certain_clearance_m_min(mission)
    # Around its place the robot ahead keeps clear.
    onward = (along_m > 0.0) & (along_m < leg_m - needs_m)
    return np.asarray((onward & (on_way_m < needs_m + slack_m)).any(axis=1))
