"""The page as a tool: what it says of a failure, how it fits a laptop, and how one gets about in it."""

import json
from collections.abc import Iterator
from pathlib import Path

import pytest
from playwright.sync_api import Browser, Page

from tests.support.pages.browser import Sight, sight
from tests.support.pages.pages import page_of
from tests.support.runs import Runs

LAPTOPS = [(1280, 720), (1366, 768), (1440, 900)]
DEATH_S = 3.9  # as the log says: the leader is known to be dead
BROKEN = {
    "promise.broken": {
        "i": [1],
        "t": [2140],
        "source": ["world"],
        "robot": [2],
        "says": ["S1 broken by r2: nearer to an obstacle than promised"],
    }
}


@pytest.fixture(scope="module")
def run(runs: Runs, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A run whose leader is killed at 3 s."""
    return runs.copy(tmp_path_factory.mktemp("tool") / "run", "grove", faults="leader-killed")


@pytest.fixture(scope="module")
def shown(browser: Browser, run: Path) -> Iterator[Sight]:
    """One page for all of these tests, on the smallest laptop."""
    report = run / "page.html"
    report.write_text(page_of(run), encoding="utf-8")
    with sight(browser, size=LAPTOPS[0]) as shown:
        shown.show(report.as_uri())
        yield shown
        assert shown.troubles == []


@pytest.fixture
def page(shown: Sight) -> Page:
    """The page at its start, with nothing chosen."""
    shown.page.evaluate("clew.choose(0); clew.seek(0)")
    return shown.page


def box(page: Page, selector: str) -> dict[str, float]:
    """Where an element is in the window [px]."""
    found = page.locator(selector).first.bounding_box()
    assert found is not None, selector
    return {"y": found["y"], "height": found["height"], "bottom": found["y"] + found["height"]}


@pytest.mark.parametrize("size", LAPTOPS)
def test_on_a_laptop_the_time_line_covers_no_robot(page: Page, size: tuple[int, int]) -> None:
    page.set_viewport_size({"width": size[0], "height": size[1]})
    page.evaluate("new Promise((done) => requestAnimationFrame(() => requestAnimationFrame(done)))")
    lanes = box(page, "#timeline")
    assert box(page, "#panes canvas")["bottom"] <= lanes["y"]
    assert box(page, "#charts")["bottom"] <= lanes["y"]
    assert lanes["bottom"] <= size[1]
    assert (
        page.evaluate("document.querySelector('#lanes-scroll').scrollHeight") == box(page, "#lanes")["height"]
    )
    page.set_viewport_size({"width": LAPTOPS[0][0], "height": LAPTOPS[0][1]})


def test_the_splitter_gives_height_to_the_lanes_or_to_the_map(page: Page) -> None:
    before = box(page, "#lanes-scroll")["height"], box(page, "#panes canvas")["height"]
    page.locator("#splitter").focus()
    for _ in range(3):
        page.keyboard.press("ArrowDown")
    page.evaluate("new Promise((done) => requestAnimationFrame(() => requestAnimationFrame(done)))")
    after = box(page, "#lanes-scroll")["height"], box(page, "#panes canvas")["height"]
    assert after[0] < before[0] - 50
    assert sum(after) == pytest.approx(sum(before), abs=1)
    page.locator("#splitter").dblclick()


def test_the_head_says_why_a_run_failed_and_leads_to_the_moment(shown: Sight) -> None:
    """This test comes last because it changes the page."""
    page = shown.page
    for reason, link, t_s, robot in (
        ("S1 broken by robot 2 at t=2.1 s: nearer to an obstacle than promised", "t=2.1 s", 2.14, 2),
        ("robot 1 died at t=3.0 s (known at t=3.9 s), and nobody had asked for it", "t=3.9 s", DEATH_S, 1),
        ("4 of 5 living robots arrived", "t=27.7 s", None, 0),
    ):
        news = {"ok": False, "reason": reason}
        page.evaluate(
            f"clew.choose(0); clew.take(0, {{ entries: {json.dumps(BROKEN)}, "
            f"verdict: {{ ...clew.runs[0].verdict, ...{json.dumps(news)} }} }})"
        )
        shown.wait(f"document.querySelector('#reason').textContent.startsWith({json.dumps(reason)})")
        page.locator("#reason a", has_text=link).click()
        assert page.evaluate("clew.robot") == robot
        if t_s is not None:
            assert page.evaluate("clew.time") == pytest.approx(t_s, abs=0.001)
    drives = "clew.frame().some(({ does }) => does === 'driving')"
    moments = f"[clew.time - 0.1, clew.time + 0.1].map((t) => (clew.seek(t), {drives}))"
    assert page.evaluate(moments) == [True, False]
