"""The summary of a run with several fleets: a line for each, then the verdict on all and the run's folder."""

from collections.abc import Iterator
from pathlib import Path

import msgspec

from protocol.errors import UsageError
from protocol.plain import plain
from world.judge.together import TogetherVerdict
from world.record.run_files import read_together


def report_together(run: str, verdict: TogetherVerdict) -> Iterator[str]:
    """The lines of a report as plain text; `run` is the folder by the path that the user gave."""
    for name, each in verdict.fleets.items():
        word = "OK" if each.ok else "FAILED"
        arrived = f"{each.robots_arrived} of {each.robots} robots arrived, t={each.sim_s:.1f} s"
        yield plain(f"{name}: {word}: {each.reason}; {arrived}")
    word = "OK" if verdict.ok else "FAILED"
    figures = f"{verdict.sim_s:.1f} s simulated in {verdict.wall_s:.1f} s"
    yield f"nearest between fleets: {verdict.nearest}; {figures}"
    yield plain(f"{word}: {verdict.reason}. Run: {run}")


def summary_of(run: str) -> str:
    """The report of a run with several fleets that has its verdict.

    Raises:
        UsageError: there is no such run.
    """
    try:
        return "\n".join(report_together(run, read_together(Path(run)))) + "\n"
    except (OSError, msgspec.MsgspecError) as error:
        raise UsageError(f"report: {run}: {error}") from error
