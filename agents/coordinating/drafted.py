"""What a coordinator has drafted, and why robots have no place in it. For people: it decides nothing.

Rule 1: a robot has a place in the draft if it is in place. Of every other robot of the mission one reason is
        told: the first that holds, in the order of the function.
"""

from collections.abc import Collection, Mapping, Set
from dataclasses import dataclass

from agents.coordinating.draft import Draft
from agents.coordinating.reported import Reported

UNREPORTED = "it has not reported"
TOO_SILENT = "it was silent, or kept the others waiting, too often lately"


@dataclass(frozen=True, slots=True)
class Drafted:
    """A draft, or the formation that was made of it."""

    order: tuple[int, ...]
    """The order that is tried, leader first; of a strand that turns round none."""
    in_place: tuple[int, ...]
    """The strand as far as it stands, leader first."""
    left_out: Mapping[int, str]
    """Why each other robot has no place."""
    awaited: Set[int]
    """The robots that the view waits for in its phase."""
    since_s: float
    """When that phase began."""


def left_out(in_place: Collection[int], draft: Draft, reported: Reported, now_s: float) -> dict[int, str]:
    """Each robot that is not in place, and why."""
    others = (each for each in range(1, reported.robots + 1) if each not in in_place)
    return {each: _reason_of(each, draft, reported, now_s) for each in others}


def _reason_of(robot: int, draft: Draft, reported: Reported, now_s: float) -> str:
    suspicion, presence = reported.suspicion, reported.suspicion.presence
    if robot in reported.counted:
        if robot not in draft.tried:
            return "its turn has not come"
        return "it has had its turn, and found no way to a place"
    if robot in suspicion.suppressed(now_s):
        return TOO_SILENT
    if presence.shows(robot):
        return "its report came too late" if robot in reported.said else UNREPORTED
    return "its token has gone" if presence.was_seen(robot) else "its token has never come"
