"""What a change of tokens is to the process that sees it: events for a robot, or for the world."""

from agents.events import TokensSeen, TokensWatched
from agents.process import addresses
from clew.rehearsal.tokens import Change, Look, Seen, Watched
from protocol.process.tokens import TokenCame, TokenWent

TokenEvent = TokenCame | TokenWent | TokensSeen | TokensWatched


def to_robot(seen: Seen) -> TokenEvent:
    """The event for a robot."""
    match seen:
        case Look(shown=shown):
            return TokensSeen(tuple(shown.items()))
        case Watched(robots=robots):
            return TokensWatched(None if robots is None else tuple(sorted(robots)))
        case Change(process=process, incarnation=incarnation, came=came):
            return (TokenCame if came else TokenWent)(process, incarnation)


def to_world(seen: Seen) -> list[TokenCame | TokenWent]:
    """The events for the world, which always watches all."""
    match seen:
        case Look(shown=shown):
            return [TokenCame(process, incarnation) for process, incarnation in shown.items()]
        case Watched():
            return []
        case Change(process=process, incarnation=incarnation, came=came):
            return [(TokenCame if came else TokenWent)(process, incarnation)]


def key_of(event: TokenEvent) -> str:
    """The key of the token."""
    if isinstance(event, TokensSeen | TokensWatched):
        return addresses.ALL_ALIVE
    return addresses.alive(event.robot, event.incarnation)
