"""The page in a browser, served by the viewer: live, late, and with two runs side by side."""

import json
import signal
import threading
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import pytest
from playwright.sync_api import Browser

from protocol.errors import UsageError
from protocol.faults.manual_faults import GoRequest, request_fault
from tests.support.deadline import DEADLINE_S
from tests.support.pages.browser import Sight, sight
from tests.support.pages.views import address_of, view
from tests.support.processes.fleets import Fleet, wait_until
from tests.support.runs import Runs

ENDED = "clew.runs[0].ended"


@pytest.fixture(scope="module")
def twins(runs: Runs) -> list[Path]:
    """The same scenario with two seeds."""
    return [runs.of("grove", seed=seed) for seed in (1, 2)]


@contextmanager
def served(*arguments: str | Path, cwd: Path) -> Iterator[str]:
    """The address of a viewer."""
    with view(*arguments, cwd=cwd) as viewer:
        yield address_of(viewer.stdout)
        viewer.send_signal(signal.SIGINT)
        assert viewer.wait(DEADLINE_S) == 130


def go(fleet: Fleet, for_s: float) -> None:
    """Let a held run go on, as soon as its world can be asked."""

    def asked() -> bool | None:
        try:
            return bool(request_fault(fleet.folder(), GoRequest(for_s=for_s)))
        except UsageError:  # it has not begun
            return None

    wait_until(asked)


def test_a_live_page_shows_moving_robots_and_then_the_verdict(browser: Browser, fleet: Fleet) -> None:
    # It is held until both pages have been opened: a browser may take longer than the rest of a run.
    launcher = fleet.start("grove", "-n", "3", "--speed", "max", "--held", "--view", "--json")
    address = address_of(launcher.stderr)
    with sight(browser) as shown:
        go(fleet, 1.0)
        shown.show(address)
        early_s = shown.page.evaluate("clew.time")
        ended_early = shown.page.evaluate(ENDED)
        go(fleet, 6.0)
        shown.wait(f"clew.time > {early_s + 5.0}")  # it follows the run
        with sight(browser) as late:
            late.show(address)
            go(fleet, 1000.0)
            late.wait(ENDED)
            outcome = fleet.end()
            shown.wait(ENDED)
            counted = "clew.runs[0].steps.length"
            assert late.page.evaluate(counted) == shown.page.evaluate(counted) > 1
            late.page.evaluate("clew.seek(0)")
            starts = late.page.evaluate("clew.frame().length")
        verdict = shown.page.evaluate("clew.runs[0].verdict")
        assert shown.troubles == []
    assert not ended_early
    assert starts == 3
    assert outcome.code == 0, outcome.err
    assert verdict == json.loads(outcome.out)
    assert fleet.leftovers() == []


def test_a_served_page_requests_only_itself_and_its_feed(
    browser: Browser, twins: list[Path], tmp_path: Path
) -> None:
    with served(twins[0], cwd=tmp_path) as address, sight(browser) as shown:
        shown.show(address)
        shown.wait(ENDED)
        assert shown.requests == [address, f"{address}events/0"]
        assert shown.troubles == []


def test_a_deep_link_into_a_served_run_lands_at_its_moment(
    browser: Browser, twins: list[Path], tmp_path: Path
) -> None:
    with served(twins[0], cwd=tmp_path) as address, sight(browser) as shown:
        shown.show(f"{address}#t=12.3&robot=3")
        shown.wait("clew.time === 12.3 && clew.robot === 3")


def test_a_deep_link_to_the_newest_moment_lands_there(
    browser: Browser, twins: list[Path], tmp_path: Path
) -> None:
    events = tmp_path / "events.jsonl"
    lines = (twins[0] / "events.jsonl").read_bytes().splitlines(keepends=True)
    times_s = [0.0, *(json.loads(line)["t_s"] for line in lines[1:])]
    asked_s = 4.0
    until = next(i for i, t_s in enumerate(times_s) if t_s >= asked_s)
    events.write_bytes(b"".join(lines[:until]))
    with kept_new(events), served(events, cwd=tmp_path) as address, sight(browser) as shown:
        shown.show(f"{address}#t={times_s[until]}")
        with events.open("ab") as file:
            file.write(lines[until])
        shown.wait(f"clew.runs[0].end === {times_s[until]}")
        with events.open("ab") as file:
            file.writelines(lines[until + 1 :])
        shown.wait(f"clew.runs[0].end > {times_s[until] + 5.0}")
        assert shown.page.evaluate("clew.time") == times_s[until]
        assert shown.page.locator("#live").get_attribute("aria-pressed") == "false"
        shown.page.keyboard.press("End")
        shown.wait("clew.time > 10.0")
        assert shown.troubles == []


def off_m(shown: Sight, run: int, row: int) -> float:
    """The distance of a run's leader from its place at this switching position."""
    there = f"clew.runs[{run}].steps.find(({{ row }}) => row.position === {row}).row"
    leader = f"clew.frame({run}).find((body) => body.robot === {there}.robot)"
    distance_m: float = shown.page.evaluate(f"Math.hypot({leader}.x - {there}.x_m, {leader}.y - {there}.y_m)")
    return distance_m


def test_two_runs_are_shown_side_by_side_aligned_by_switching_step(
    browser: Browser, twins: list[Path], tmp_path: Path
) -> None:
    with served(*twins, cwd=tmp_path) as address, sight(browser) as shown:
        shown.show(address)
        shown.wait("clew.runs.length === 2 && clew.runs.every((run) => run.ended)")
        assert shown.page.locator("#panes canvas").count() >= 2
        panes = shown.page.locator("#panes > .pane")  # measured at once: the page may still be laid out
        left, right = panes.evaluate_all(
            "(panes) => panes.map((pane) => pane.getBoundingClientRect().toJSON())"
        )
        assert left["x"] + left["width"] <= right["x"]
        assert left["y"] == right["y"]
        shown.page.evaluate("clew.seek(clew.runs[0].steps.find(({ row }) => row.position === 3).to)")
        assert [off_m(shown, index, 3) for index in (0, 1)] == pytest.approx([0.0, 0.0], abs=0.01)
        late_s = "Math.abs(clew.charts[0].others[0]?.curve.t.last - clew.runs[0].end)"
        shown.wait(f"{late_s} < 0.5")  # in the time of the other run
        curves = "clew.charts[0].others.map(({ name, curve }) => [name, curve.value.length])"
        known = "clew.runs[1].robots.map((r) => [`B: r${r}`, clew.runs[1].body(r).clearance.value.length])"
        assert shown.page.evaluate(curves) == shown.page.evaluate(known)
        step = "clew.runs[%d].steps.find(({ row }) => row.position === 3).to + 0.001"
        there = (
            f"clew.charts[0].others[0].curve.at({step % 0}) - clew.runs[1].body(1).clearance.at({step % 1})"
        )
        assert shown.page.evaluate(there) == 0.0
        about = shown.page.locator("#differences-about").inner_text()
        assert about == "Started differently: seed. The first step that differs is step 1."
        rows = shown.page.locator("#differences tr").all_inner_texts()
        assert "seed\t1\t2" in rows
        assert any(row.startswith("step 1\tr1 to (") and row.endswith(" m away") for row in rows)
        assert shown.troubles == []


def test_a_page_shows_the_next_run_when_latest_points_to_it(
    browser: Browser, twins: list[Path], tmp_path: Path
) -> None:
    latest = tmp_path / "runs" / "latest"
    latest.parent.mkdir()
    with served("--live", cwd=tmp_path) as address, sight(browser) as shown:
        shown.page.goto(address)
        assert "Waiting" in shown.page.locator("#notice").inner_text()
        assert not shown.page.locator("#timeline").is_visible()
        for seed, run in enumerate(twins, start=1):
            latest.with_name("link").symlink_to(run)
            latest.with_name("link").replace(latest)
            shown.wait(f"clew.runs[0]?.subject?.seed === {seed} && {ENDED}")
            shown.wait(f"document.querySelector('#facts').innerText.endsWith('in {run.name}')")
        assert not shown.page.locator("#notice").is_visible()
        assert shown.troubles == []


@contextmanager
def kept_new(log: Path) -> Iterator[None]:
    """Keep a log looking live, even on a slow machine."""
    over = threading.Event()

    def touch() -> None:
        while not over.wait(1.0):
            log.touch()

    thread = threading.Thread(target=touch)
    thread.start()
    try:
        yield
    finally:
        over.set()
        thread.join()


def test_a_page_reports_that_its_viewer_is_gone_while_the_run_continues(
    browser: Browser, twins: list[Path], tmp_path: Path
) -> None:
    events = (twins[0] / "events.jsonl").read_bytes()
    half = tmp_path / "half.jsonl"
    half.write_bytes(events[: len(events) // 2])
    with sight(browser) as shown:
        with kept_new(half), served(half, cwd=tmp_path) as address:
            shown.show(address)
            assert not shown.page.locator("#notice").is_visible()
        shown.page.locator("#notice").wait_for()
        assert "away" in shown.page.locator("#notice").inner_text()
