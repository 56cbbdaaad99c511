"""Who may be struck in a swarm, from when and until when. Pure."""

from collections.abc import Sequence
from dataclasses import dataclass

from clew.swarm.draws import Draws
from protocol.keys import robot_name

SOON_S = 0.5  # five odometries: whoever is to be struck is there by then, or is spared
BEGINS_S = (0.5, 16.0)  # fleets are under way by then, and most are not yet there


@dataclass(frozen=True, slots=True)
class Window:
    """Who may be struck, and until when."""

    robots: int
    until_s: float | None
    """None: faults go on to the end."""

    @property
    def begins_s(self) -> tuple[float, float]:
        """When faults may begin."""
        low_s, high_s = BEGINS_S
        return low_s, high_s if self.until_s is None else min(high_s, self.until_s - low_s)

    def ends_s(self, from_s: float, draws: Draws) -> float | None:
        """When a fault ends that began then; one in two lasts as long as it may."""
        if draws.chance(0.5):
            return self.until_s
        end_s = round(from_s + draws.scale(0.5, 15.0), 3)
        return end_s if self.until_s is None else min(end_s, self.until_s)

    def lasts_s(self, from_s: float, wished_s: float) -> float:
        """For how long something lasts that began then, and is over in time."""
        return wished_s if self.until_s is None else max(0.1, round(min(wished_s, self.until_s - from_s), 3))


def names(window: Window) -> Sequence[str]:
    """The robots."""
    return [robot_name(robot) for robot in range(1, window.robots + 1)]


def times(draws: Draws, window: Window) -> tuple[float, float | None]:
    """From when until when; one in three from the start."""
    from_s = 0.0 if draws.chance(0.33) else draws.between(*window.begins_s)
    return from_s, window.ends_s(from_s, draws)
