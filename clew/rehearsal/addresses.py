"""The keys of a rehearsal as the message counts use them: without the root that all keys of a run share."""

from functools import cache

from protocol.keys import WORLD, Keys, robot_name

_KEYS = Keys("clew", "rehearsed")


@cache
def muster(robot: int) -> str:
    """Messages from the robot to all others."""
    return _KEYS.behind_root(_KEYS.muster(robot_name(robot)))


@cache
def link(robot: int, other: int) -> str:
    """Messages from the robot to one neighbour."""
    return _KEYS.behind_root(_KEYS.link(robot_name(robot), robot_name(other)))


@cache
def drive(robot: int) -> str:
    """The robot's orders to its body."""
    return _KEYS.behind_root(_KEYS.drive(robot_name(robot)))


@cache
def scan(robot: int) -> str:
    """The robot's scan queries and their answers."""
    return _KEYS.behind_root(_KEYS.scan(robot_name(robot)))


@cache
def odometry(robot: int) -> str:
    """The odometry from the robot's body."""
    return _KEYS.behind_root(_KEYS.odometry(robot_name(robot)))


@cache
def alive(process: int, incarnation: str) -> str:
    """The liveliness token of a process; process 0 is the world."""
    source = robot_name(process) if process else WORLD
    return _KEYS.behind_root(_KEYS.alive(source, incarnation))
