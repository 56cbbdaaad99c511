"""How often, and for how long, a robot asks the world for its mission. Pure.

Rule 1 (liveness): no robot gives up before the world does that starts beside it.
Rule 2: a robot asks when it sees the world's token: before that nobody may be there to answer. The period
        only counts where a message is lost, so it may be long.
"""

from protocol.mission import start_wall_s

RETRY_S = 0.3  # wall
# 1,000 robots that asked every 0.3 s kept two cores busy: a world of 200 fleets had not begun within 60 s.
RETRY_S_PER_ROBOT = 0.004
PATIENCE_S = 60.0  # wall


def mission_times_s(robots: int) -> tuple[float, float]:
    """The period, and for how long: beside so many robots, of all fleets of the run [wall s]."""
    return max(RETRY_S, RETRY_S_PER_ROBOT * robots), max(PATIENCE_S, start_wall_s(robots))


class Asking:
    """When one robot asks for its mission."""

    def __init__(self, robots: int, now_s: float) -> None:
        """Begin to wait for the world, beside so many robots."""
        self._period_s, patience_s = mission_times_s(robots)
        self._until_s, self._due_s = now_s + patience_s, now_s + self._period_s
        self._world_is_there = False

    def world_came(self) -> None:
        """The world's token has appeared: ask now (rule 2)."""
        self._world_is_there = True

    def asks(self, now_s: float) -> bool:
        """Whether to ask now; the period begins anew."""
        if not self._world_is_there and now_s < self._due_s:
            return False
        self._world_is_there, self._due_s = False, now_s + self._period_s
        return True

    def wait_s(self, now_s: float) -> float:
        """How long until it asks again."""
        return max(self._due_s - now_s, 0.0)

    def is_over(self, now_s: float) -> bool:
        """Whether it gives up."""
        return now_s >= self._until_s
