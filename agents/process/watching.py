"""Whose liveliness tokens a robot's process watches. Pure.

Rule 1: it watches those of the robots that matter to its core, and always two: of the world and of the robot
        beside it in number. If it sees none, its session is deaf (`protocol.network.deafness`).
Rule 2: tokens that come one after the other are one event. Each event is a step of the core: in a fleet of
        1000, a coordinator would take 0.3 s for all tokens one by one, and 2 ms at once.
"""

from collections.abc import Sequence
from itertools import groupby

from agents.events import TokensSeen
from agents.process.addresses import ALL_ALIVE
from agents.process.journal import Given
from protocol.process.tokens import TokenCame


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


def at_once(all_given: Sequence[Given]) -> list[Given]:
    """The same inputs, by rule 2."""
    if len(all_given) <= 1:
        return list(all_given)
    found: list[Given] = []
    for _, group in groupby(all_given, lambda given: isinstance(given.event, TokenCame)):
        run = list(group)
        shown = tuple(
            (each.event.robot, each.event.incarnation) for each in run if isinstance(each.event, TokenCame)
        )
        found += [Given(TokensSeen(shown), ALL_ALIVE, 0)] if len(shown) > 1 else run
    return found
