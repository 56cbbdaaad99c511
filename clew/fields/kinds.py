"""The kinds of fields and the usual values of their parameters: what the command line says of them."""

from enum import StrEnum

WIDTH_RADII = 4.0  # r + epsilon is at most 1.5 r, so this is a third more than the fleet needs
ROBOT_RADIUS_M = 0.15  # as in most scenes from public data
DENSITY = 0.06  # fits for every kind at the default width
SIZE_M = (10.0, 6.0)  # a room


class Kind(StrEnum):
    """The obstacles of a field."""

    CIRCLES = "circles"
    ELLIPSES = "ellipses"
    CONVEX = "convex"
    NONCONVEX = "nonconvex"
    MIXED = "mixed"
    STARS = "stars"
    CORRIDORS = "corridors"
    ZIGZAG = "zigzag"
    COMB = "comb"
    SPIRAL = "spiral"
    RINGS = "rings"
    ROOMS = "rooms"
    PILLARS = "pillars"
