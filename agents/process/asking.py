"""How often, and for how long, a robot asks the world for its mission. Pure.

Rule 1 (liveness): no robot gives up before the world does that starts beside it.
Rule 2: a robot also asks when a token comes. That of the world does, so the period may be long: it only
        counts where a message is lost.
"""

from protocol.mission import start_wall_s

RETRY_S = 0.3  # wall
# 1,000 robots that asked every 0.3 s kept two cores busy: a world of 200 fleets had not begun within 60 s.
RETRY_S_PER_ROBOT = 0.004
PATIENCE_S = 60.0  # wall


def mission_times_s(robots: int) -> tuple[float, float]:
    """The period, and for how long: beside so many robots, of all fleets of the run [wall s]."""
    return max(RETRY_S, RETRY_S_PER_ROBOT * robots), max(PATIENCE_S, start_wall_s(robots))
