"""What a robot's process hears, and which message is which event for its core. Pure.

Rule 1: a message is an event only on the key of its kind; its sender is the one that the key names.
"""

from functools import lru_cache

from agents.events import Event, LinkHeard, OdometryHeard, ScanHeard, TokensWatched, ViewHeard
from agents.process.addresses import ALL_ALIVE
from agents.process.journal import Given
from protocol.keys import WORLD, Keys, robot_name, robot_number
from protocol.network.transport import Heard
from protocol.wire.messages import AheadState, BehindState, Odometry, Scan
from protocol.wire.view import Answer, Formation, Plea, Report


def heard(keys: Keys, name: str) -> list[str]:
    """All that a robot listens to, but for tokens."""
    return [
        keys.link("*", name),
        keys.view("*", name),
        keys.odometry(name),
        keys.logged(name),
        keys.fault(name),
    ]


def tokens_of(keys: Keys, robots: frozenset[int] | None) -> list[str]:
    """The patterns of the tokens of these robots and the world; None: of all."""
    if robots is None:
        return [keys.tokens_of("*")]
    return [keys.tokens_of(WORLD), *(keys.tokens_of(robot_name(each)) for each in sorted(robots))]


def listed(robots: frozenset[int] | None) -> Given:
    """The tokens that are watched have come."""
    watched = TokensWatched(None if robots is None else tuple(sorted(robots)))
    return Given(watched, ALL_ALIVE, 0)


def event_for(name: str, key: str, arrival: Heard, now_s: float) -> Event | None:
    """The event for a message; None if the robot does not use this message on this key (rule 1).

    Args:
        name: the robot's.
        key: the message's, without the run's root.
        arrival: the message.
        now_s: the time of the newest odometry; older ones are no events.
    """
    what, sender, robot = _parts(key)
    match arrival.message:
        case AheadState() | BehindState() as state if what == "link" and robot:
            return LinkHeard(robot, arrival.number, state)
        case Odometry() as odometry if what == "odometry" and sender == name and odometry.t_s == now_s:
            return OdometryHeard(odometry)
        case Scan() as scan if what == "scan" and sender == name:
            return ScanHeard(scan)
        case Report() | Answer() | Formation() | Plea() as said if what == "view" and robot:
            return ViewHeard(robot, arrival.number, said)
        case _:
            return None


@lru_cache(maxsize=4096)  # a few keys tell nearly all; a flood of others pushes out the oldest
def _parts(key: str) -> tuple[str, str, int | None]:
    """What is told on a key, its sender or its body, and the number of that robot, if it is one."""
    match key.split("/"):
        case ["link" | "view" as what, sender, _]:
            return what, sender, robot_number(sender)
        case ["body", body, "odometry" | "scan" as what]:
            return what, body, robot_number(body)
        case _:
            return "", "", None
