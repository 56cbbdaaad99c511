"""Breadth-first search over all orders of events; a breach is found by one of its shortest traces."""

from enum import StrEnum
from time import process_time
from typing import NamedTuple

from tests.model.acting import acts
from tests.model.bodies import come_to_rest, obey, obeyed, stand
from tests.model.coordinator import coordinates
from tests.model.properties import Breach, Property
from tests.model.robots import hear, hear_odometry
from tests.model.setting import Setting
from tests.model.state import Message, Odometry, Order, Raise, Release, Stand, State, Steps, Turn
from tests.model.values import AT_REST, REGISTER_NUMBER, Body, Epoch, Fence, Reading, Robot
from tests.model.world import hear_raise, hear_release, hear_turn, operator_steps, restart_world


class Ended(StrEnum):
    """Why a search ended."""

    BREACH = "breach"
    CLOSED = "closed"  # every state within the bounds was seen
    DEPTH = "depth"
    TIME = "time"


class Found(NamedTuple):
    """What a search found."""

    broken: Property | None
    trace: list[str]
    states: int
    depth: int
    ended: Ended
    cpu_s: float


def start(setting: Setting) -> State:
    """All robots run, know the first fence, and nothing has happened."""
    bounds = setting.bounds
    fence = Fence(Epoch(0, REGISTER_NUMBER, 0))
    robot = Robot(know=fence, reading=AT_REST)
    bodies, robots = (Body(),) * bounds.robots, (robot,) * bounds.robots
    return State(fence, bodies, robots, frozenset(), bounds.raises, bounds.faults, bounds.late, bounds.stops)


def steps(setting: Setting, state: State) -> Steps:
    """All that may happen next. Raises `Breach` where a body obeys an order against a property."""
    for i in range(setting.bounds.robots):
        yield from acts(setting, state, i)
        yield from coordinates(setting, state, i)
        yield from tells_odometry(setting, state, i)
        yield from come_to_rest(state, i)
        robot = state.robots[i]
        if state.faults and "r" in setting.bounds.restarts and robot != Robot(robot.life):
            next_life = state.with_robot(i, Robot(robot.life + 1))
            yield f"r{i} restarts", next_life._replace(faults=state.faults - 1)
    if state.faults and "w" in setting.bounds.restarts:
        yield from restart_world(setting, state)
    yield from operator_steps(setting, state)
    for message in state.net:
        yield from arrives(setting, state, message)


def tells_odometry(setting: Setting, state: State, i: int) -> Steps:
    """Robot `i` hears its odometry, or it is held up."""
    body = state.bodies[i]
    reading = Reading(body.place, body.motion is not None, body.ended, state.in_force)
    now = Odometry(i, state.fence, reading)
    yield f"odometry -> r{i}", hear_odometry(setting, state, now)
    if state.late:
        yield f"odometry to r{i} is delayed", state._replace(net=state.net | {now}, late=state.late - 1)


def arrives(setting: Setting, state: State, message: Message) -> Steps:
    """A message that was sent arrives."""
    match message:
        case Raise():
            yield from hear_raise(setting, state, message)
        case Turn():
            yield from hear_turn(setting, state, message)
        case Release():
            yield from hear_release(setting, state, message)
        case Odometry():
            yield f"late odometry -> r{message.to}", hear_odometry(setting, state.heard(message), message)
        case Stand():
            yield from stand(state, message)
        case Order():
            yield obeyed(message), obey(setting, state, message)
        case _:
            yield f"{type(message).__name__} -> r{message.to}", hear(setting, state, message)


class Seen:
    """The states seen, by hash, each with the one before it."""

    def __init__(self, first: State) -> None:
        self.before: dict[int, tuple[int, str] | None] = {hash(first): None}

    def add(self, state: State, before: int, happened: str) -> bool:
        """Is the state a new one?"""
        key = hash(state)
        if key in self.before:
            return False
        self.before[key] = (before, happened)
        return True

    def trace(self, key: int) -> list[str]:
        """What happened up to a state."""
        happened = []
        while (step := self.before[key]) is not None:
            key, said = step
            happened.append(said)
        return happened[::-1]


def search(setting: Setting, seconds: float = 60.0) -> Found:
    """Search within the bounds, for at most so many seconds of CPU."""
    began, depth, first = process_time(), 0, start(setting)
    seen, level = Seen(first), [first]
    while level and depth < setting.bounds.depth:
        following: list[State] = []
        for state in level:
            key = hash(state)
            try:
                following += [
                    after
                    for happened, after in steps(setting, state)
                    if after is not None and seen.add(after, key, happened)
                ]
            except Breach as breach:
                trace = [*seen.trace(key), obeyed(breach.order)]
                return Found(
                    breach.broken, trace, len(seen.before), depth + 1, Ended.BREACH, process_time() - began
                )
            if process_time() - began > seconds:
                return Found(None, [], len(seen.before), depth, Ended.TIME, process_time() - began)
        level, depth = following, depth + 1
    ended = Ended.DEPTH if level else Ended.CLOSED
    return Found(None, [], len(seen.before), depth, ended, process_time() - began)
