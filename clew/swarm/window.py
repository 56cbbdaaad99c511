"""Which robots a swarm's faults may affect, from when and until when. Pure."""

from collections.abc import Sequence
from dataclasses import dataclass

from clew.swarm.draws import Draws
from protocol.keys import robot_name

SOON_S = 0.5  # five odometry periods: a target that has not started by then is spared
BEGINS_S = (0.5, 16.0)  # most fleets have started by then and have not arrived


@dataclass(frozen=True, slots=True)
class Window:
    """The robots that faults may affect, and until when."""

    robots: int
    until_s: float | None
    """None: faults last to the end."""

    @property
    def begins_s(self) -> tuple[float, float]:
        """The range of times at which faults may begin."""
        low_s, high_s = BEGINS_S
        return low_s, high_s if self.until_s is None else min(high_s, self.until_s - SOON_S)

    def ends_s(self, from_s: float, draws: Draws) -> float | None:
        """When a fault that begins at `from_s` ends; half of them last as long as the window."""
        if draws.chance(0.5):
            return self.until_s
        end_s = round(from_s + draws.scale(0.5, 15.0), 3)
        return end_s if self.until_s is None else min(end_s, self.until_s)

    def lasts_s(self, from_s: float, wanted_s: float) -> float:
        """The wanted duration, shortened so that the fault ends within the window."""
        return wanted_s if self.until_s is None else max(0.1, round(min(wanted_s, self.until_s - from_s), 3))


def names(window: Window) -> Sequence[str]:
    """The names of the robots."""
    return [robot_name(robot) for robot in range(1, window.robots + 1)]


def times(draws: Draws, window: Window) -> tuple[float, float | None]:
    """From when until when a fault lasts; one in three begins at the start."""
    from_s = 0.0 if draws.chance(0.33) else draws.between(*window.begins_s)
    return from_s, window.ends_s(from_s, draws)
