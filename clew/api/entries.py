"""An entry of the timeline, and a message, as users see them."""

from dataclasses import dataclass
from typing import Any

import msgspec

from protocol.plain import plain
from protocol.timeline import Entry as Written
from protocol.timeline import Record, kind_of
from protocol.timeline.sentences import sentence


@dataclass(frozen=True, slots=True)
class Entry:
    """An entry; the fields of its kind (docs/timeline.md) are attributes as well: `entry.step`."""

    source: str
    """`world`, or `r3`."""
    written: Written

    @property
    def t_s(self) -> float:
        """Simulated time."""
        return self.written.t_s

    @property
    def kind(self) -> str:
        """As `step.planned`."""
        return kind_of(self.written.record)

    @property
    def record(self) -> Record:
        """Its fields, typed."""
        return self.written.record

    def __getattr__(self, name: str) -> Any:  # noqa: ANN401 - a field of any kind
        record = self.written.record
        try:
            return getattr(record, name)
        except AttributeError:
            fields = ", ".join(("t_s", "source", "kind", *record.__struct_fields__))
        # Many ask the entry of a robot for its number, which is in the source.
        raise AttributeError(
            f"{self.kind} has no field {name!r}, only {fields}; its source is {self.source!r}"
        )

    def as_dict(self) -> dict[str, Any]:
        """All fields as plain data, as in the log."""
        stamp = {"t_s": self.t_s, "source": self.source, "n": self.written.n, "kind": self.kind}
        return {**stamp, **msgspec.to_builtins(self.written.record)}

    def __str__(self) -> str:
        return plain(f"t={self.t_s:.3f} s {self.source}: {sentence(self.source, self.record)}")
