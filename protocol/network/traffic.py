"""Counts of messages by key, at one process; the books of the fleet are made from them."""

from collections import Counter
from collections.abc import Callable, Collection, Mapping
from dataclasses import dataclass, field

from msgspec.structs import replace

from protocol.timeline import TrafficCounted
from protocol.wire.codec import fits

REFUSED_KEYS_MAX = 100  # a peer that may send on any key must not fill our memory, nor our last entry
OTHERS = "others"


@dataclass(slots=True)
class Traffic:
    """The messages that one process sent and received. Pure counting: the shell reports the messages."""

    sent: Counter[str] = field(default_factory=Counter)
    received: Counter[str] = field(default_factory=Counter)
    newest: dict[str, int] = field(default_factory=dict)
    """The highest message number received, by key: numbers missing below it were lost."""
    injected: Counter[tuple[str, str]] = field(default_factory=Counter)
    """Messages that a fault plan removed here, by key and fault; they do not count as received."""
    refused: Counter[str] = field(default_factory=Counter)
    """Messages that broke the protocol, by key."""
    overflowed_count: int = 0

    def send(self, key: str) -> int:
        """Count one sent message; returns its number on that key, from 1."""
        self.sent[key] += 1
        return self.sent[key]

    def note_overflow(self, count: int) -> None:
        """Note how many messages the full inbox has dropped in all."""
        self.overflowed_count = count

    def receive(self, key: str, number: int) -> None:
        """Count one received message."""
        self.received[key] += 1
        self._note_number(key, number)

    def refuse(self, key: str) -> None:
        """Count one received message that broke the protocol: its number cannot be read."""
        known = key in self.refused or len(self.refused) < REFUSED_KEYS_MAX
        self.refused[key if known else OTHERS] += 1

    def count_removed(self, key: str, number: int, fault: str) -> None:
        """Count one message that arrived and was removed by a fault plan."""
        self.injected[key, fault] += 1
        self._note_number(key, number)

    def move_to_removed(self, key: str, number: int, fault: str) -> None:
        """Move a message from received to removed: a fault plan removed it."""
        self.received[key] -= 1
        self.count_removed(key, number, fault)

    def injected_by_fault(self) -> dict[str, dict[str, int]]:
        """The messages that a fault plan removed here: by fault, then by key."""
        by_fault: dict[str, dict[str, int]] = {}
        for (key, fault), count in sorted(self.injected.items()):
            by_fault.setdefault(fault, {})[key] = count
        return by_fault

    def counted(
        self, said: Callable[[str], str] = str, *, apart: Collection[str] = (), unrecorded: int = 0
    ) -> TrafficCounted:
        """The record of the counts.

        Args:
            said: a key as it is in the timeline.
            apart: keys that are not counted there.
            unrecorded: entries that its full outbox has refused.
        """

        def of(counts: Mapping[str, int]) -> dict[str, int]:
            return {said(key): count for key, count in counts.items() if key not in apart}

        return TrafficCounted(
            sent=of(self.sent),
            received=of(self.received),
            newest=of(self.newest),
            injected={fault: of(counts) for fault, counts in self.injected_by_fault().items()},
            refused=of(self.refused),
            overflowed=self.overflowed_count,
            unrecorded=unrecorded,
        )

    def _note_number(self, key: str, number: int) -> None:
        self.newest[key] = max(number, self.newest.get(key, 0))


def in_parts(counted: TrafficCounted) -> list[TrafficCounted]:
    """The same counts in as many entries as they need to fit into messages; the last has those of queues."""
    if fits(counted):
        return [counted]
    by_key = (counted.sent, counted.received, counted.newest, counted.refused, *counted.injected.values())
    keys = sorted({key for counts in by_key for key in counts})
    first = set(keys[: len(keys) // 2])
    low = replace(_of(counted, lambda key: key in first), overflowed=0, unrecorded=0)
    return [*in_parts(low), *in_parts(_of(counted, lambda key: key not in first))]


def joined(one: TrafficCounted, other: TrafficCounted) -> TrafficCounted:
    """The counts of two entries of one source as one."""
    faults = sorted(one.injected.keys() | other.injected.keys())
    return TrafficCounted(
        sent={**one.sent, **other.sent},
        received={**one.received, **other.received},
        newest={**one.newest, **other.newest},
        injected={
            fault: {**one.injected.get(fault, {}), **other.injected.get(fault, {})} for fault in faults
        },
        refused={**one.refused, **other.refused},
        overflowed=one.overflowed + other.overflowed,
        unrecorded=one.unrecorded + other.unrecorded,
    )


def _of(counted: TrafficCounted, is_of: Callable[[str], bool]) -> TrafficCounted:
    """The counts of some keys."""

    def some(counts: Mapping[str, int]) -> dict[str, int]:
        return {key: count for key, count in counts.items() if is_of(key)}

    return replace(
        counted,
        sent=some(counted.sent),
        received=some(counted.received),
        newest=some(counted.newest),
        injected={fault: some(counts) for fault, counts in counted.injected.items()},
        refused=some(counted.refused),
    )
