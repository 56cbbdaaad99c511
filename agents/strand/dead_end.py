"""The way out of a dead end: how far the strand has to back up before its leader can go another way.

The strand backs up along its own path, as a train does. So this computes from which place of the path the
goal can be reached past the robots behind. These will then take up as much of the path as they do now.
"""

from collections.abc import Callable

import numpy as np

from agents.navigation.ground import Ground
from protocol.arrays import Floats, xy

PLACES_APART_BERTHS = 1.0  # how fine the path is searched, in least distances of a centre


def way_back_m(ground: Ground, berth_m: float, reachable: Callable[[Floats, Floats], bool]) -> float | None:
    """An arc length from which the goal can be reached; None where there is none.

    It is one place short of the farthest, from where the certificate may refuse what the map shows.

    Backing up only frees ground in front, so from every place before it the goal can be reached too.

    Args:
        ground: the strand behind the leader, which stands at the path's end.
        berth_m: least distance of a centre from an obstacle.
        reachable: whether the goal can be reached from a place (2,), with so much ground taken (n, 2).
    """
    places_m = np.append(np.arange(0.0, ground.path.end_m, PLACES_APART_BERTHS * berth_m), ground.path.end_m)

    def reaches(index: int) -> bool:
        return reachable(xy(ground.path.at(places_m[index])), ground.taken_from(places_m[index]))

    good, bad = -1, len(places_m) - 1
    while bad - good > 1:
        middle = (good + bad) // 2
        good, bad = (middle, bad) if reaches(middle) else (good, middle)
    return float(places_m[max(good - 1, 0)]) if good >= 0 else None
