"""The books of a run: what was sent, what was received, and what is accounted for by nothing.

Rule 1: a key has one sender; each of its receivers is a book of its own: `muster` has all other robots.
Rule 2: odometry flows on while robots count, so its book is closed at the newest that the robot received.
Rule 3: where one side never told its counts (it died), the book is left out and named; what was taken away
        of it is counted apart, as far as the timeline tells.
Rule 4: what a fault plan took away was injected at its receiver, and is neither received nor unaccounted.
        What arrived damaged is among it. What else was refused is a message of that key that was damaged on
        its way, if one is wanting, and else none of the fleet's.
Rule 5: the recorder's keys are not in the books: entries have numbers, re-sending and completeness of
        their own; nor are queries.
"""

from collections import Counter
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from types import MappingProxyType

from msgspec import Struct

from protocol.keys import WORLD, robot_name

Book = tuple[str, str]
"""A key, and one of its receivers."""


class Messages(Struct, frozen=True, kw_only=True):
    """What became of the messages of a run."""

    sent: int
    received: int
    injected: dict[str, int]
    """Messages that a fault plan took away, by fault."""
    refused: int
    """Messages that arrived, and could not be read."""
    unaccounted: int
    """Sent, but neither received, taken away nor refused: truly lost."""
    left_out: tuple[str, ...]
    """Books that have only one side, as `key > receiver`."""
    injected_left_out: dict[str, int] = {}
    """Messages of those books that a fault plan is known to have taken away, by fault: not in `injected`."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Account:
    """What one source counted, by the part of the key behind the run's root."""

    sent: Mapping[str, int]
    received: Mapping[str, int]
    newest: Mapping[str, int]
    injected: Mapping[str, Mapping[str, int]] = field(default_factory=dict)
    """Of what came, what a fault plan took away: by fault, then by key."""
    refused: Mapping[str, int] = field(default_factory=dict)


def balance(
    accounts: Mapping[str, Account],
    *,
    robots: Sequence[int],
    taken: Mapping[Book, Mapping[str, int]] = MappingProxyType({}),
) -> Messages:
    """Balance the books of all sources that told their counts; the world is one of them.

    Args:
        accounts: of each source.
        robots: the fleet.
        taken: what receivers have recorded to be taken away, by book and fault.
    """
    sent = received = refused = 0
    injected: Counter[str] = Counter()
    elsewhere: Counter[str] = Counter()
    left_out: list[str] = []
    told = {key for account in accounts.values() for key in (*account.sent, *account.newest)}
    told.update(key for key, _ in taken)
    for key in sorted(told):
        for sender, receiver in _ends(key, robots):
            if sender not in accounts or receiver not in accounts:
                left_out.append(f"{key} > {receiver}")
                elsewhere.update(taken.get((key, receiver), {}))
                continue
            heard = accounts[receiver]
            away = Counter({fault: counts.get(key, 0) for fault, counts in heard.injected.items()})
            sent_here = (heard.newest if sender == WORLD else accounts[sender].sent).get(key, 0)
            received_here = heard.received.get(key, 0)
            wanting = max(0, sent_here - received_here - away.total())
            sent, received = sent + sent_here, received + received_here
            refused += min(wanting, heard.refused.get(key, 0))
            injected.update(away)
    return Messages(
        sent=sent,
        received=received,
        injected=dict(sorted((+injected).items())),
        refused=refused,
        unaccounted=sent - received - injected.total() - refused,
        left_out=tuple(left_out),
        injected_left_out=dict(sorted(elsewhere.items())),
    )


def _ends(key: str, robots: Sequence[int]) -> Iterator[tuple[str, str]]:
    """The sender of a key and each of its receivers; nobody where the key is not in the books."""
    match key.split("/"):
        case ["link", sender, receiver]:
            yield sender, receiver
        case ["body", robot, "drive"]:
            yield robot, WORLD
        case ["body", robot, "odometry"]:
            yield WORLD, robot
        case ["muster", sender]:
            yield from ((sender, name) for name in map(robot_name, robots) if name != sender)
        case _:
            pass
