"""A run that is over: the viewer names the same flaws as the report, and recognises a quiet run."""

import json
import os
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

import msgspec
import pytest

from clew.log import follow as following
from clew.log import vigil
from clew.log.completeness import TOLD_MAX
from clew.log.follow import Follower, look
from clew.log.vigil import Vigil
from clew.page.serve.channel import Channel
from clew.page.serve.watch import Began, Over, Watch
from clew.page.telling import Telling
from tests.support.deadline import DEADLINE_S
from tests.support.logs.logs import AT_REST, GOOD, numbered, recorded
from world.control import Serves, heard
from world.judge.verdict import VERDICT_FILE
from world.record.recorder import EVENTS_FILE

LINES = numbered(AT_REST)


@pytest.fixture
def run(tmp_path: Path) -> Path:
    return recorded(tmp_path / "run", LINES)


def let_rest(run: Path) -> None:
    """Make the run's files look as if nothing had been written for some time."""
    for path in run.iterdir():
        os.utime(path, (time.time() - 2 * DEADLINE_S,) * 2)


def told(run: Path) -> list[dict[str, Any]]:
    """The messages to pages of a run that is no longer written."""
    let_rest(run)
    channel, batches = Channel(Watch(run)), list[bytes]()
    while said := list(channel._look()):
        batches += [each for each in said if isinstance(each, bytes)]
    return [json.loads(batch) for batch in batches]


def lines_changed(run: Path, change: Callable[[list[bytes]], list[bytes]]) -> None:
    path = run / EVENTS_FILE
    path.write_bytes(b"".join(change(path.read_bytes().splitlines(keepends=True))))


DAMAGE: dict[str, Callable[[list[bytes]], list[bytes]]] = {
    "torn": lambda lines: [*lines[:-1], lines[-1][:-9]],
    "interrupted": lambda lines: lines[:-1],
    "holes": lambda lines: [lines[0], *lines[3:]],
    "twice": lambda lines: [lines[0], *(line for line in lines[1:] for _ in range(2))],
    "disorder": lambda lines: [lines[0], *lines[:0:-1]],
    "newer": lambda lines: [lines[0].replace(b"timeline/1", b"timeline/9"), *lines[1:]],
    "unknown kinds": lambda lines: [line.replace(b"pose.sampled", b"pose.dreamt") for line in lines],
    "bad lines": lambda lines: [*lines, *[b"{bad}\n"] * (2 * TOLD_MAX)],
    "no header": lambda lines: lines[1:],
    "damaged header": lambda lines: [b'{"seed":7}\n', *lines[1:]],
    "whole": lambda lines: lines,
}


@pytest.mark.parametrize("verdict", [None, msgspec.json.encode(GOOD), b"{", b"[1]", b"", b"{}"])
@pytest.mark.parametrize("damage", DAMAGE)
def test_the_viewer_names_the_same_flaws_of_a_finished_run_as_the_report(
    run: Path, damage: str, verdict: bytes | None
) -> None:
    lines_changed(run, DAMAGE[damage])
    if verdict is not None:
        (run / VERDICT_FILE).write_bytes(verdict)
    batches = told(run)
    reported = json.loads(list(Telling(run).batches())[-1])
    assert batches[-1]["ended"] is True
    flaws = [batch["flaws"] for batch in batches if "flaws" in batch]
    assert (flaws[-1] if flaws else None) == reported.get("flaws")
    assert batches[-1].get("verdict") == reported.get("verdict")


def test_an_empty_log_is_over_and_reported_as_empty(run: Path) -> None:
    (run / EVENTS_FILE).write_bytes(b"")
    (batch,) = told(run)
    assert batch["flaws"] == list(Telling(run).flaws)


def test_of_many_bad_lines_only_the_first_are_reported_and_none_twice(
    run: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(following, "READ_BYTES", 1000)
    lines_changed(run, lambda lines: [*lines[:2], *[b"{bad}\n", lines[1]] * 1000])
    batches = told(run)
    flaws = [batch["flaws"] for batch in batches if "flaws" in batch]
    assert len(batches) > 10 * len(flaws)
    assert len(flaws[-1]) < 2 * TOLD_MAX


def test_a_run_that_was_written_recently_may_continue(run: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(vigil, "QUIET_S", DEADLINE_S)
    watch = Watch(run)
    watch.look()
    assert watch.look() == []
    let_rest(run)
    (over,) = watch.look()
    assert isinstance(over, Over)
    assert watch.look() == []


def never_ended(name: str) -> None:
    raise AssertionError(f"asked to end {name}")


def never_asked(*, stop: bool) -> str:
    raise AssertionError(f"asked to stop: {stop}")


async def test_a_quiet_run_whose_world_is_reachable_is_not_over(run: Path, tmp_path: Path) -> None:
    let_rest(run)
    quiet = Vigil(run / EVENTS_FILE)
    async with heard(tmp_path, run, Serves(lambda *_: "never asked", never_ended, never_asked, str)):
        assert not quiet.is_over(ended=False)
        assert quiet.is_over(ended=True)
    assert Vigil(run / EVENTS_FILE).is_over(ended=False)


def test_a_run_that_continues_after_its_end_is_sent_from_its_start(run: Path) -> None:
    lines_changed(run, lambda lines: lines[:-1])
    let_rest(run)
    watch = Watch(run)
    watch.look()
    (over,) = watch.look()
    assert isinstance(over, Over)
    (run / VERDICT_FILE).write_bytes(msgspec.json.encode(GOOD))
    assert isinstance(watch.look()[0], Began)
    (over,) = watch.look()
    assert isinstance(over, Over)
    assert over.verdict is not None


def test_a_line_that_is_too_long_is_skipped_and_reported_once(
    run: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    path = run / EVENTS_FILE
    header = path.read_bytes().partition(b"\n")[0]
    monkeypatch.setattr(following, "LINE_BYTES_MAX", 2 * len(header))
    monkeypatch.setattr(following, "READ_BYTES", 1000)
    lines_changed(run, lambda lines: [lines[0], b"x" * 7 * len(header) + b"\n", *lines[1:]])
    follower = Follower(path)
    count, flaws, size_bytes = 0, list[str](), path.stat().st_size
    while (before := follower.whole_bytes) < size_bytes:
        news = look(follower)
        count, flaws = count + len(news.lines), [*flaws, *news.flaws]
        assert follower.whole_bytes > before or follower.torn_bytes
    assert count == len(LINES)
    assert flaws == [f"line 2 is longer than {2 * len(header)} bytes: dropped"]
