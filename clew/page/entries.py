"""All entries of the timeline except poses, in columns by kind, with all their fields."""

from collections.abc import Callable
from dataclasses import dataclass, field
from operator import attrgetter
from typing import Any

from clew.page.columns import MS, column, pair, plain
from clew.story.steps import gap_ends
from protocol.timeline import (
    AuthorityGranted,
    Entry,
    FaultInjected,
    OrderAccepted,
    OrderFinished,
    Record,
    ScanServed,
    SegmentChecked,
    StepPlanned,
    kind_of,
)
from protocol.timeline.sentences import sentence

Packed = dict[str, dict[str, list[Any]]]

UNSAID = frozenset({AuthorityGranted, OrderAccepted, OrderFinished, ScanServed, SegmentChecked})
"""Frequent kinds that need no sentence: the page draws them."""
AWAY = ": an obstacle has come nearer, and the step leads away from it"


@dataclass(slots=True)
class Entries:
    """Collects the newest entries until they are packed."""

    leads_away: Callable[[StepPlanned], bool]
    """Whether a step promises less than required."""
    _heard: dict[type[Record], list[tuple[int, str, Entry]]] = field(default_factory=dict)

    def hear(self, index: int, source: str, entry: Entry) -> None:
        """Add an entry; `index` counts all entries of the log."""
        kind = type(entry.record)
        heard = self._heard.get(kind)
        if heard is None:
            self._heard[kind] = [(index, source, entry)]
        else:
            heard.append((index, source, entry))

    def pack(self) -> Packed:
        """All entries since the last call."""
        packed = {
            kind_of(heard[0][2].record): self._columns(kind, heard) for kind, heard in self._heard.items()
        }
        self._heard.clear()
        return packed

    def _columns(self, kind: type[Record], heard: list[tuple[int, str, Entry]]) -> dict[str, list[Any]]:
        index, source, entries = zip(*heard, strict=True)
        records = [entry.record for entry in entries]
        columns: dict[str, list[Any]] = {
            "i": column(index, 1.0),
            "t": column([entry.t_s for entry in entries], MS),
            "source": list(source),
            **{name: plain(list(map(attrgetter(name), records))) for name in kind.__struct_fields__},
        }
        if kind not in UNSAID:
            columns["says"] = list(map(self._says, source, records))
        if kind is StepPlanned:
            columns["ends"] = [_ends(record) for record in records]
        return columns

    def _says(self, source: str, record: Record) -> str | None:
        if isinstance(record, FaultInjected) and record.process is None:
            return None  # messages are counted, not listed
        is_away = isinstance(record, StepPlanned) and self.leads_away(record)
        return sentence(source, record) + (AWAY if is_away else "")


def _ends(plan: StepPlanned) -> list[Any]:
    return [None if ends is None else list(map(pair, ends)) for ends in gap_ends(plan)]
