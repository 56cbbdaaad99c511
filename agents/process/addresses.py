"""A robot's keys as message counts and journals have them: without the root that all keys of a run share."""

from functools import cache
from typing import assert_never

from agents.commands import Order, Put, Say, Tell
from protocol.keys import WORLD, WORLD_NUMBER, Keys, robot_name
from protocol.wire.messages import Message

_KEYS = Keys("any", "run")
ALL_ALIVE = "alive"  # of an event on several tokens


@cache
def view(robot: int, other: int) -> str:
    """Messages of a view from the robot to another."""
    return _KEYS.behind_root(_KEYS.view(robot_name(robot), robot_name(other)))


@cache
def fence(robot: int) -> str:
    """What the robot puts to change the fence."""
    return _KEYS.behind_root(_KEYS.fence(robot_name(robot)))


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


def addressed(robot: int, command: Say | Tell | Put | Order) -> tuple[int, str, Message]:
    """The receiver, the key and the message of a robot's command."""
    match command:
        case Say(other, said):
            return other, view(robot, other), said
        case Tell(other, state):
            return other, link(robot, other), state
        case Put(change):
            return WORLD_NUMBER, fence(robot), change
        case Order(order):
            return WORLD_NUMBER, drive(robot), order
        case _:
            assert_never(command)
