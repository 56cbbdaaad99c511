"""What a coordinator tells the robot that it gives a turn. Pure."""

from collections.abc import Mapping

from agents.coordinating.draft import Draft
from agents.coordinating.legs import line_of
from agents.coordinating.order import places_of, positions
from agents.coordinating.questions import points
from protocol.wire.view import Join, Report


def join_for(draft: Draft, robot: int, reports: Mapping[int, Report], turn: int) -> Join:
    """Where the strand ends that the robot joins in this turn, and where the other robots stand."""
    strand, places = draft.front, places_of(reports)
    line, leg = line_of(places, strand, draft.legs)
    waiting = [other for other in places if other != robot and other not in strand]
    return Join(
        turn=turn,
        strand=points(positions(places, strand)),
        waiting=points(positions(places, waiting)),
        robots=tuple(sorted((*strand, *waiting))),
        line=points(line),
        last_leg=int((leg == leg[-1]).sum()) if len(leg) else 0,
    )
