"""How long a fleet may take to start: for so long the world waits for robots, and robots for the clock."""

START_WALL_S = 30.0
"""Wall: with 40 busy processes on two cores, five robots take 15 s to come; on an idle machine 0.5 s."""
START_WALL_S_PER_ROBOT = 0.5
"""Wall: 50 robots take 2 s on two idle cores; ten times that leaves room for a busy machine."""


def start_wall_s(robots: int) -> float:
    """How long the robots of a fleet of this size may take to come [wall s]."""
    return START_WALL_S + START_WALL_S_PER_ROBOT * robots
