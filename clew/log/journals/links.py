"""One thing on the way to an entry, or from it."""

from dataclasses import dataclass
from typing import Any

from protocol.plain import plain
from protocol.timeline import Entry, kind_of
from protocol.timeline.sentences import sentence


@dataclass(frozen=True, slots=True)
class Link:
    """One thing on the way."""

    t_s: float
    source: str
    what: str
    """`entry`, `decision`, `law`, `message`, `odometry`, `scan`, `token`, `loss`, `fault`, `draft`, `start`,
    `end`; forward: `effect` or `note`."""
    said: str
    input: int = 0
    """Of a decision or an input: the number of the input in the journal of its process, from 1."""
    key: str = ""
    number: int = 0
    """Of the message that carried it; 0: none, or it has none."""

    def as_dict(self) -> dict[str, Any]:
        """As plain data."""
        return {name: getattr(self, name) for name in self.__dataclass_fields__}


def of_entry(source: str, entry: Entry, what: str = "entry") -> Link:
    """An entry on the way."""
    return Link(entry.t_s, source, what, f"{kind_of(entry.record)}: {plain(sentence(source, entry.record))}")
