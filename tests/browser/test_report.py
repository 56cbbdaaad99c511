"""The page in a browser, opened from `file://` like a report that was sent to somebody."""

import json
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path

import pytest
from playwright.sync_api import Browser

from protocol.root import ROOT
from tests.support.campaigns import clew
from tests.support.deadline import DEADLINE_S
from tests.support.pages.browser import Sight, sight
from tests.support.pages.chromium import PHONE
from tests.support.runs import Runs
from world.record.recorder import EVENTS_FILE

ROBOTS = 5
MOVED_M = 0.5  # in 10 s, at 0.5 m/s and less


@pytest.fixture(scope="module")
def report(runs: Runs, tmp_path_factory: pytest.TempPathFactory) -> str:
    """The address of the report of a run with a leader killed at 3 s."""
    run = runs.copy(tmp_path_factory.mktemp("page") / "run", "grove", faults="leader-killed")
    made = clew("report", run)
    assert made.exit_code == 0, made.output
    return Path(made.stdout.strip()).resolve().as_uri()


@pytest.fixture
def shown(browser: Browser, report: str) -> Iterator[Sight]:
    with sight(browser) as shown:
        shown.show(report)
        yield shown


def places(shown: Sight) -> dict[int, tuple[float, float]]:
    """The current places of the robots [m; world frame]."""
    bodies = shown.page.evaluate("clew.frame().map((body) => [body.robot, body.x, body.y])")
    return {robot: (x_m, y_m) for robot, x_m, y_m in bodies}


def drawn(shown: Sight) -> bytes:
    """The current picture of the map."""
    shown.page.evaluate("clew.draw()")
    return shown.page.locator("#panes canvas").first.screenshot()


def test_it_opens_without_errors_and_requests_only_itself(shown: Sight, report: str) -> None:
    assert shown.troubles == []
    assert shown.requests == [report]


def test_the_browser_would_refuse_a_request_of_the_page(shown: Sight) -> None:
    refused = shown.page.evaluate("fetch('http://127.0.0.1:9/').then(() => false, () => true)")
    assert refused
    assert "Content Security Policy" in " ".join(shown.troubles)


def test_scrubbing_moves_robots_and_scrubbing_back_restores_them(shown: Sight) -> None:
    shown.page.evaluate("clew.seek(5)")
    before, picture = places(shown), drawn(shown)
    assert sorted(before) == list(range(1, ROBOTS + 1))
    shown.page.evaluate("clew.seek(clew.runs[0].end - 1)")
    after = places(shown)
    moved_m = [abs(complex(*after[robot]) - complex(*before[robot])) for robot in (2, 3, 4, 5)]
    assert min(moved_m) > MOVED_M
    assert after[1] == before[1]  # it is dead at this time
    assert drawn(shown) != picture
    shown.page.evaluate("clew.seek(5)")
    assert places(shown) == before
    assert drawn(shown) == picture


def test_the_mouse_scrubs_the_time_line(shown: Sight) -> None:
    box = shown.page.locator("#lanes").bounding_box()
    assert box is not None
    middle = box["y"] + box["height"] / 2
    times_s = []
    for share in (0.3, 0.6, 0.9):
        shown.page.mouse.click(box["x"] + share * box["width"], middle)
        times_s.append(shown.page.evaluate("clew.time"))
    assert times_s == sorted(set(times_s))
    assert times_s[0] > 0.0


def test_a_deep_link_lands_at_its_moment(browser: Browser, report: str) -> None:
    with sight(browser) as shown:
        shown.show(f"{report}#t=12.3&robot=3")
        shown.wait("clew.time === 12.3 && clew.robot === 3")
        shown.wait("document.querySelector('#clock').innerText.startsWith('12.3')")


def test_the_address_follows_the_shown_moment(shown: Sight) -> None:
    shown.page.evaluate("clew.seek(7.5); clew.choose(4)")
    shown.wait("location.hash === '#t=7.50&robot=4'")


def test_keys_play_step_choose_and_move(shown: Sight) -> None:
    press = shown.page.keyboard.press
    press("Home")
    assert shown.page.evaluate("clew.time") == 0
    press("]")
    first_s = shown.page.evaluate("clew.time")
    press("]")
    second_s = shown.page.evaluate("clew.time")
    assert 0 < first_s < second_s
    press("[")
    assert shown.page.evaluate("clew.time") == first_s
    press("Shift+ArrowRight")
    assert shown.page.evaluate("clew.time") == pytest.approx(first_s + 1.0)
    press("3")
    assert shown.page.evaluate("clew.robot") == 3
    press("Escape")
    assert shown.page.evaluate("clew.robot") == 0
    press("Home")
    press("Space")
    shown.wait("clew.time > 0.3")
    press("Space")
    press("End")
    assert shown.page.evaluate("clew.time === clew.runs[0].end")
    assert shown.troubles == []


@pytest.fixture(scope="module")
def planned(report: str) -> list[tuple[float, int]]:
    """The planning time of each step of the strand [s], with its number in the log."""
    lines = (Path(report.removeprefix("file://")).parent / EVENTS_FILE).read_bytes().splitlines()
    entries = (json.loads(line) for line in lines)
    plans = [each for each in entries if each["kind"] == "step.planned" and not each["joins"]]
    return [(plan["t_s"], plan["step"]) for plan in plans]


def test_band_headline_list_and_table_number_each_step_like_the_log(
    shown: Sight, planned: list[tuple[float, int]]
) -> None:
    bands = shown.page.evaluate("clew.runs[0].steps.map((each) => [each.from, each.step])")
    assert bands == [[pytest.approx(t_s), step] for t_s, step in planned]
    rows = shown.page.locator("#steps tbody th").all_inner_texts()
    assert rows == ["start", *(str(step) for _, step in planned)]
    for t_s, step in planned:
        shown.page.evaluate(f"clew.seek({t_s + 0.05}); clew.draw()")
        assert shown.page.locator("#strand-now").inner_text().startswith(f"step {step} ·")
        assert shown.page.locator("#steps [aria-current] th").inner_text() == str(step)
        assert f"plans step {step}:" in shown.page.locator("#moments [aria-current]").inner_text()


def test_the_bracket_keys_go_to_every_planned_step(shown: Sight, planned: list[tuple[float, int]]) -> None:
    shown.page.keyboard.press("Home")
    times_s = set()
    while (time_s := shown.page.evaluate("clew.time")) < planned[-1][0]:
        times_s.add(time_s)
        shown.page.keyboard.press("]")
    assert times_s >= {t_s for t_s, _ in planned[:-1]}


def test_the_verdict_is_at_the_top_in_words(shown: Sight) -> None:
    assert "promises" in shown.page.locator("#verdict").inner_text().lower()
    assert "4 of 5" in shown.page.locator("#verdict").inner_text()


def test_on_a_phone_the_page_scrolls_only_vertically(browser: Browser, report: str) -> None:
    with sight(browser, size=PHONE) as shown:
        shown.show(report)
        wide = shown.page.evaluate("[document.documentElement.scrollWidth, window.innerWidth]")
        assert wide == [PHONE[0], PHONE[0]]


@pytest.mark.parametrize("size", [(1080, 1920), (1400, 2600), (1400, 900)])
def test_the_map_fills_its_card(browser: Browser, report: str, size: tuple[int, int]) -> None:
    with sight(browser, size=size) as shown:
        shown.show(report)
        bottom = "document.querySelector('%s').getBoundingClientRect().bottom"
        below = f"{bottom % '#stage'} - {bottom % '#panes canvas'}"
        assert shown.page.evaluate(below) < 40  # px


def test_on_a_phone_in_landscape_the_time_line_covers_nothing(browser: Browser, report: str) -> None:
    with sight(browser, size=(844, 390)) as shown:
        shown.show(report)
        top = "document.querySelector('#timeline').getBoundingClientRect().top"
        stage_end = "document.querySelector('#stage').getBoundingClientRect().bottom"
        assert shown.page.evaluate(f"{top} >= {stage_end}")


def test_it_follows_the_browsers_dark_theme_and_a_key_changes_it(browser: Browser, report: str) -> None:
    brightness = (
        "getComputedStyle(document.body).backgroundColor.match(/\\d+/g).slice(0, 3)"
        ".reduce((sum, each) => sum + Number(each), 0) / 765"
    )
    with sight(browser, dark=True) as shown:
        shown.show(report)
        assert shown.page.evaluate(brightness) < 0.3
        shown.page.keyboard.press("d")
        assert shown.page.evaluate(brightness) > 0.7


@pytest.mark.long
def test_the_bench_scrubs_a_page_and_every_frame_is_drawn(report: str) -> None:
    run = Path(report.removeprefix("file://")).parent
    bench = [sys.executable, "-m", "tests.support.pages.bench", str(run)]
    said = subprocess.run(
        bench, cwd=ROOT, capture_output=True, timeout=DEADLINE_S, check=True, text=True
    ).stdout
    assert said.startswith(f"{ROBOTS} robots")
    assert "a page of 0." in said
    assert " 0.0 ms of a frame" not in said


def test_these_tests_notice_errors_of_a_page(browser: Browser, report: str) -> None:
    with sight(browser) as shown:
        shown.show(report)
        shown.page.evaluate("console.error('said')")
        shown.page.evaluate("setTimeout(() => { clew.planted = true; throw Error('thrown'); })")
        shown.wait("clew.planted")
        assert shown.troubles == ["said", "thrown"]
