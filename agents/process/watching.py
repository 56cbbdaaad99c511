"""Whose liveliness tokens a robot's process watches. Pure.

Rule 1: it watches those of the robots that matter to its core, and always two: of the world and of the robot
        beside it in number. If it sees none, its session is deaf (`protocol.network.deafness`).
"""


def beside(robot: int) -> int:
    """The robot whose token another always watches."""
    return robot - 1 if robot > 1 else robot + 1


def watched_by(robot: int, wanted: frozenset[int] | None) -> frozenset[int] | None:
    """The robots that a process watches; None: all.

    Args:
        robot: its number.
        wanted: the robots that matter to its core; None: all.
    """
    return None if wanted is None else wanted | {beside(robot)}
