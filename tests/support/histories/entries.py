"""Runs entry by entry: each entry has a name, so that a test says which ones it changes."""

from collections.abc import Iterable, Mapping

from protocol.timeline import Entry, Record, RobotStarted

Said = tuple[float, str, Record]


def changed(
    lawful: Mapping[str, Said], *more: Said, without: tuple[str, ...] = (), **other: Said
) -> list[Said]:
    """A run in order of time: with more entries, without some, or with others in their place.

    Underscores in names of entries stand for spaces. More entries come after those of the same time.
    """
    named = {name.replace("_", " "): said for name, said in other.items()}
    assert not (named.keys() | set(without)) - lawful.keys(), "no such entries"
    kept = {name: said for name, said in {**lawful, **named}.items() if name not in without}
    return sorted([*kept.values(), *more], key=lambda said: said[0])


def lines_of(said: Iterable[Said]) -> list[tuple[str, Entry]]:
    """The entries, numbered by source."""
    counts: dict[str, int] = {}
    lines: list[tuple[str, Entry]] = []
    for t_s, source, record in said:
        counts[source] = 1 if isinstance(record, RobotStarted) else counts.get(source, 0) + 1
        lines.append((source, Entry(n=counts[source], t_s=t_s, hlc="", record=record)))
    return lines
