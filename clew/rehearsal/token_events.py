"""What a change of tokens is to the process that sees it: events for a robot, or for the world."""

from agents.events import TokenCame as TokenSeen
from agents.events import TokensSeen
from agents.events import TokenWent as TokenMissed
from agents.process import addresses
from clew.rehearsal.tokens import Change, FirstLook
from world.events import TokenCame, TokenWent

TokenEvent = TokenSeen | TokenMissed | TokensSeen
ALL_ALIVE = "alive"  # a first look is at all keys of tokens


def to_robot(change: Change | FirstLook) -> TokenEvent:
    """The event for a robot."""
    if isinstance(change, FirstLook):
        return TokensSeen(tuple(change.shown.items()))
    event = TokenSeen if change.came else TokenMissed
    return event(change.process, change.incarnation)


def to_world(change: Change | FirstLook) -> list[TokenCame | TokenWent]:
    """The events for the world."""
    if isinstance(change, FirstLook):
        return [TokenCame(process, incarnation) for process, incarnation in change.shown.items()]
    event = TokenCame if change.came else TokenWent
    return [event(change.process, change.incarnation)]


def key_of(event: TokenEvent) -> str:
    """The key of the token."""
    return ALL_ALIVE if isinstance(event, TokensSeen) else addresses.alive(event.robot, event.incarnation)
