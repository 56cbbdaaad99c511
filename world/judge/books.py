"""The books of a run: messages sent, received, and unaccounted for.

Rule 1: a key has one sender and one receiver. The keys of the operator, who counts nothing, have no book.
Rule 2: odometry continues while robots count. So its book ends at the newest message that the robot received.
Rule 3: a book without the counts of one side (a dead robot) is left out and listed. Messages of it that a
        fault plan removed are counted separately, as far as they are recorded.
Rule 4: messages that a fault plan removed were injected at the receiver. They are neither received nor
        unaccounted for; messages that the plan damaged are among them. Another refused message counts as a
        message of its key that was damaged on its way, if one is missing there, and else as foreign.
Rule 5: every key is compared by itself: a message too many on one key does not make up for one that was lost
        on another. What a receiver counted as removed by faults must be what it recorded, fault by fault.
Rule 6: the recorder's keys are not in the books: its entries have their own numbers, re-sending and check of
        completeness. Queries are not in the books either.
Rule 7: the books on which most is unaccounted for are named. A link that is down shows there: on all keys of
        one process, or of all.
"""

from collections import Counter
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from types import MappingProxyType

from msgspec import Struct

from protocol.keys import WORLD, ends_of
from protocol.timeline import TrafficCounted

TAKES_AWAY = ("drop", "partition", "corrupt")  # other faults leave a valid message
DISAGREEMENTS_MAX = LOST_MAX = 20  # named in the verdict

Book = tuple[str, str]
"""A key, and one of its receivers."""


class Messages(Struct, frozen=True, kw_only=True):
    """The books of a run, balanced."""

    sent: int
    received: int
    injected: dict[str, int]
    """Messages that a fault plan removed, by fault."""
    refused: int
    """Messages that arrived and could not be decoded."""
    unaccounted: int
    """Sent, but neither received, removed nor refused: truly lost."""
    left_out: tuple[str, ...]
    """Books with the counts of one side only, as `key > receiver`."""
    disagreements: tuple[str, ...] = ()
    """Books whose two sides, or whose counts and entries, contradict each other (rule 5); the first ones."""
    injected_left_out: dict[str, int] = {}
    """Messages of those books that a fault plan is known to have removed, by fault; not in `injected`."""
    unaccounted_on: dict[str, int] = {}
    """Of `unaccounted`: how many on which books, as in `left_out`, most first; the first ones."""


def balance(
    accounts: Mapping[str, TrafficCounted],
    *,
    removed: Mapping[Book, Mapping[str, int]] = MappingProxyType({}),
) -> Messages:
    """Balance the books of all sources that recorded their counts; the world is one of them.

    Args:
        accounts: the account of each source.
        removed: recorded removals by fault plans, by book and fault.
    """
    settled: dict[str, _Settled] = {}
    left_out: list[str] = []
    elsewhere: Counter[str] = Counter()
    told = {key for account in accounts.values() for key in (*account.sent, *account.newest)}
    told.update(key for key, _ in removed)
    for key in sorted(told):
        ends = ends_of(key)
        if ends is None:
            continue
        sender, receiver = ends
        name, recorded = f"{key} > {receiver}", removed.get((key, receiver), {})
        if sender in accounts and receiver in accounts:
            settled[name] = _settle(
                key, accounts[sender], accounts[receiver], recorded, until_newest=sender == WORLD
            )
        else:
            left_out.append(name)
            elsewhere.update(recorded)
    books = settled.values()
    unaccounted = Counter({name: book.unaccounted for name, book in settled.items() if book.unaccounted})
    injected: Counter[str] = Counter()
    for book in books:
        injected.update(book.injected)
    disagreements = [f"{name}: {each}" for name, book in settled.items() for each in book.disagreements]
    return Messages(
        sent=sum(book.sent for book in books),
        received=sum(book.received for book in books),
        injected=dict(sorted((+injected).items())),
        refused=sum(book.refused for book in books),
        unaccounted=unaccounted.total(),
        disagreements=tuple(disagreements[:DISAGREEMENTS_MAX]),
        left_out=tuple(left_out),
        injected_left_out=dict(sorted(elsewhere.items())),
        unaccounted_on=dict(unaccounted.most_common(LOST_MAX)),
    )


@dataclass(frozen=True, slots=True)
class _Settled:
    """What became of the messages of one book."""

    sent: int
    received: int
    injected: Counter[str]
    refused: int
    unaccounted: int
    disagreements: tuple[str, ...]


def _settle(
    key: str,
    sender: TrafficCounted,
    receiver: TrafficCounted,
    recorded: Mapping[str, int],
    *,
    until_newest: bool,
) -> _Settled:
    """Settle one book, from the accounts of its two sides; with rule 2, or without."""
    counted, received = sender.sent.get(key, 0), receiver.received.get(key, 0)
    sent = receiver.newest.get(key, 0) if until_newest else counted
    away = Counter({fault: counts.get(key, 0) for fault, counts in receiver.injected.items()})
    wanting = max(0, sent - received - away.total())
    refused = min(wanting, receiver.refused.get(key, 0))
    disagreements = _disagreements(
        sent=min(sent, counted), arrived=received + away.total(), counted=+away, recorded=recorded
    )
    return _Settled(sent, received, away, refused, wanting - refused, tuple(disagreements))


def _disagreements(
    *, sent: int, arrived: int, counted: Mapping[str, int], recorded: Mapping[str, int]
) -> Iterator[str]:
    """Rule 5, for one book."""
    if arrived > sent:
        yield f"{arrived} messages arrived of {sent} that were sent"
    for fault in TAKES_AWAY:
        count, entries = counted.get(fault, 0), recorded.get(fault, 0)
        if count != entries:
            yield f"{fault} took away {count} messages by its count and {entries} by its entries"
