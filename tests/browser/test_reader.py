"""The page by keys alone, and as a screen reader is told of it."""

from collections.abc import Iterator
from pathlib import Path

import pytest
from playwright.sync_api import Browser, Page

from tests.support.pages.browser import Sight, sight
from tests.support.pages.pages import page_of
from tests.support.runs import Runs

FOCUSED = "document.activeElement?.getAttribute('%s') ?? ''"
SAID = "document.querySelector('#spoken').textContent"


@pytest.fixture(scope="module")
def shown(browser: Browser, runs: Runs, tmp_path_factory: pytest.TempPathFactory) -> Iterator[Sight]:
    """The page of a run whose leader is killed at 3 s."""
    run: Path = runs.copy(tmp_path_factory.mktemp("reader") / "run", "grove", faults="leader-killed")
    report = run / "page.html"
    report.write_text(page_of(run), encoding="utf-8")
    with sight(browser, size=(1280, 720)) as shown:
        shown.show(report.as_uri())
        yield shown
        assert shown.troubles == []


def tab_to(page: Page, name: str) -> None:
    """Press Tab until the element with this label has the focus."""
    page.locator("#theme").focus()  # the first of all
    for _ in range(60):
        page.keyboard.press("Tab")
        if page.evaluate(FOCUSED % "aria-label").startswith(name):
            return
    pytest.fail(f"Tab does not lead to {name}")


@pytest.mark.parametrize(
    ("name", "at_s", "then"),
    [
        ("Time", 12.6, ": step 4; r1 dead; r2, r3, r4, r5 driving"),
        ("Time", 3.0, "kill r1"),
        ("Clearance [m]", 12.6, ": r2: 0."),
        ("Separation [m]", 12.6, ": hulls: 0."),
    ],
)
def test_charts_and_lanes_are_sliders_of_time_that_say_what_they_show(
    shown: Sight, name: str, at_s: float, then: str
) -> None:
    page = shown.page
    page.evaluate(f"clew.choose(0); clew.seek({at_s})")
    tab_to(page, name)
    assert page.evaluate(FOCUSED % "role") == "slider"
    shown.wait(f"document.activeElement.getAttribute('aria-valuetext').includes({then!r})")
    assert page.evaluate(FOCUSED % "aria-valuetext").startswith(f"{at_s:.2f} seconds of ")
    before = page.evaluate(FOCUSED % "aria-valuetext")
    page.keyboard.press("ArrowRight")
    shown.wait(f"document.activeElement.getAttribute('aria-valuenow') === '{at_s + 0.1:.2f}'")
    assert page.evaluate(FOCUSED % "aria-valuetext") != before


def test_what_the_pointer_is_told_is_said_aloud(shown: Sight) -> None:
    found = shown.page.locator("#lanes").bounding_box()
    assert found is not None
    shown.page.mouse.move(found["x"] + found["width"] / 2, found["y"] + 10.0)
    shown.wait(f"{SAID}.startsWith('step 4 of r2: ')")
    assert shown.page.evaluate(SAID) == shown.page.locator("#tip").inner_text()
    shown.page.mouse.move(0, 0)


def test_keys_go_through_what_is_on_the_map(shown: Sight) -> None:
    page = shown.page
    page.evaluate("clew.choose(0); clew.seek(12.6)")
    tab_to(page, "Map of run")
    for key, said in (("x", "robot 1: dead"), ("x", "robot 2, which leads: driving"), ("X", "robot 1: dead")):
        page.keyboard.press(key)
        shown.wait(f"{SAID}.startsWith({said!r})")
    for _ in range(5):
        page.keyboard.press("x")
    shown.wait(f"{SAID}.startsWith('obstacle 1: circle, radius 0.22 m')")
    assert page.locator("#tip").is_visible()
    page.keyboard.press("ArrowRight")
    assert not page.locator("#tip").is_visible()
