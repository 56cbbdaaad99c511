"""A law that prefers room: it ends its steps where obstacles are far, if that costs little of the way."""

import math

import numpy as np

from clew import Seen, Step

BEARINGS = 90  # directions that are tried
SHARES = np.linspace(0.25, 1.0, 4)  # of the longest certified step in each of them
ROOM_M = 0.6  # more room than this is worth nothing
PRICE = 2.0  # so many metres of way for one metre of room


def roomy(seen: Seen) -> Step | None:
    """The goal, if it can be reached now; else the step whose end has the least way and the most room."""
    assert seen.goal is not None, "it goes by the ways to a goal"
    to_goal = seen.step_to(seen.goal)
    if to_goal.length_m <= seen.free_m([to_goal.heading_rad])[0]:
        return to_goal
    bearings_rad = np.linspace(-math.pi, math.pi, BEARINGS, endpoint=False)
    lengths_m = np.outer(seen.free_m(bearings_rad), SHARES)
    rays = np.stack([np.cos(bearings_rad), np.sin(bearings_rad)], axis=1)
    ends = (seen.position + lengths_m[:, :, None] * rays[:, None, :]).reshape(-1, 2)
    costs_m = seen.cost_to_go_m(ends)
    apart_m = np.hypot(*np.moveaxis(ends[:, None] - seen.remembered, -1, 0)).min(axis=1, initial=ROOM_M)
    nearer = costs_m < seen.cost_to_go_m(seen.position[None])[0] - 0.05  # so that it never goes in circles
    if not nearer.any():
        return None
    best = int(np.argmin(np.where(nearer, costs_m - PRICE * apart_m, np.inf)))
    return seen.step_to(ends[best])
