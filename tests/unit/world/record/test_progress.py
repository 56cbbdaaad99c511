"""The progress messages of a run, one line each."""

from protocol.timeline import KINDS, Entry, FaultInjected, LinkSilent
from tests.support.planned import planned
from tests.support.strands import formed, raised, turn
from world.record.progress import AWAITED, progress


def test_only_relevant_entries_are_reported() -> None:
    lost = FaultInjected(fault="drop", rule="loss", key="link/r1/r2", number=7)
    struck = FaultInjected(fault="kill", rule="kill-1", process="r1")
    told = [
        progress(source, Entry(n=1, t_s=1.0, hlc="", record=record))
        for source, record in (
            ("r2", planned(3)), ("r1", LinkSilent(neighbour=2, silent_s=0.5)), ("r1", formed(1, 2, 1)),
            ("r1", lost), ("world", struck), raised(20_002), turn(20_002, 1, 3),
        )
    ]  # fmt: skip
    assert told == [
        "t=   1.0 s  r2 plans step 3: 1.000 m", None, "t=   1.0 s  strand formed: r2 < r1",
        None, "t=   1.0 s  kill-1: kill r1",
        "t=   1.0 s  all bodies stand, because the run begins: r2 coordinates a view", None,
    ]  # fmt: skip


def test_what_is_awaited_are_kinds_of_entries() -> None:
    assert KINDS.keys() >= AWAITED
