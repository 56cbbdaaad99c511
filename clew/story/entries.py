"""All entries of the timeline but poses, in columns by kind; none is left out, and no field of theirs."""

from dataclasses import dataclass, field
from operator import attrgetter
from typing import Any

from clew.story.columns import MS, column, plain
from protocol.timeline import Entry, Record

Packed = dict[str, dict[str, list[Any]]]


@dataclass(slots=True)
class Entries:
    """The newest entries, until they are packed."""

    _heard: dict[type[Record], list[tuple[int, str, Entry]]] = field(default_factory=dict)

    def hear(self, index: int, source: str, entry: Entry) -> None:
        """Take an entry in; `index` counts all entries of the log."""
        kind = type(entry.record)
        heard = self._heard.get(kind)
        if heard is None:
            self._heard[kind] = [(index, source, entry)]
        else:
            heard.append((index, source, entry))

    def pack(self) -> Packed:
        """All that came since the last time."""
        packed = {_tag(kind): _columns(kind, heard) for kind, heard in self._heard.items()}
        self._heard.clear()
        return packed


def _tag(kind: type[Record]) -> str:
    tag = kind.__struct_config__.tag
    assert isinstance(tag, str), kind
    return tag


def _columns(kind: type[Record], heard: list[tuple[int, str, Entry]]) -> dict[str, list[Any]]:
    index, source, entries = zip(*heard, strict=True)
    records = [entry.record for entry in entries]
    return {
        "i": column(index, 1.0),
        "t": column([entry.t_s for entry in entries], MS),
        "source": list(source),
        **{name: plain(list(map(attrgetter(name), records))) for name in kind.__struct_fields__},
    }
