"""The keys of a rehearsal, as they stand in the books: without what all keys of a run start with."""

from functools import cache

from protocol.keys import WORLD, Keys, robot_name

_KEYS = Keys("clew", "rehearsed")


@cache
def muster(robot: int) -> str:
    """What the robot says to all."""
    return _KEYS.behind_root(_KEYS.muster(robot_name(robot)))


@cache
def link(robot: int, other: int) -> str:
    """What it says to one neighbour."""
    return _KEYS.behind_root(_KEYS.link(robot_name(robot), robot_name(other)))


@cache
def drive(robot: int) -> str:
    """Its orders."""
    return _KEYS.behind_root(_KEYS.drive(robot_name(robot)))


@cache
def scan(robot: int) -> str:
    """Its scans, asked for and answered."""
    return _KEYS.behind_root(_KEYS.scan(robot_name(robot)))


@cache
def odometry(robot: int) -> str:
    """What its body tells it."""
    return _KEYS.behind_root(_KEYS.odometry(robot_name(robot)))


@cache
def alive(process: int, incarnation: str) -> str:
    """Its liveliness token; process 0 is the world."""
    source = robot_name(process) if process else WORLD
    return _KEYS.behind_root(_KEYS.alive(source, incarnation))
