"""The page as a tool: what it says of a failure, how it fits a laptop, and how one gets about in it."""

import json
import math
import tomllib
from collections.abc import Iterator
from itertools import pairwise
from pathlib import Path
from xml.etree import ElementTree as ET

import msgspec
import pytest
from playwright.sync_api import Browser, Page

from clew.log import timeline
from protocol.faults.plan import Plan
from protocol.run_settings import read_plan
from protocol.timeline import AuthorityGranted, OrderAccepted, StepPlanned
from tests.support.pages.browser import Sight, sight
from tests.support.pages.pages import page_of
from tests.support.runs import Runs
from world.record.recorder import EVENTS_FILE

LAPTOPS = [(1280, 720), (1366, 768), (1440, 900)]
DEATH_S = 3.9  # as the log says: the leader is known to be dead
BROKEN = {
    "promise.broken": {
        "i": [1],
        "t": [2140],
        "source": ["world"],
        "robot": [2],
        "says": ["S1 (clearance) broken by r2: nearer to an obstacle than promised"],
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


def settle(page: Page) -> None:
    """Wait until what was done has been drawn: events of the mouse come with frames."""
    page.evaluate("new Promise((done) => requestAnimationFrame(() => requestAnimationFrame(done)))")


@pytest.fixture
def page(shown: Sight) -> Page:
    """The page at its start, with nothing chosen; what the test before has moved is back in its place."""
    shown.page.evaluate("clew.choose(0); clew.seek(0); clew.draw()")
    settle(shown.page)
    return shown.page


def box(page: Page, selector: str) -> dict[str, float]:
    """Where an element is in the window [px]."""
    found = page.locator(selector).first.bounding_box()
    assert found is not None, selector
    return {"y": found["y"], "height": found["height"], "bottom": found["y"] + found["height"]}


@pytest.mark.parametrize("size", LAPTOPS)
def test_on_a_laptop_the_time_line_covers_no_robot(page: Page, size: tuple[int, int]) -> None:
    page.set_viewport_size({"width": size[0], "height": size[1]})
    settle(page)
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
    settle(page)
    after = box(page, "#lanes-scroll")["height"], box(page, "#panes canvas")["height"]
    assert after[0] < before[0] - 50
    assert sum(after) == pytest.approx(sum(before), abs=1)
    page.locator("#splitter").dblclick()


def said_at(page: Page, selector: str, x: float, y: float) -> str:
    """What the page says of this place of a canvas, across as a share of it, down in pixels."""
    page.mouse.move(0, 0)
    found = page.locator(selector).first.bounding_box()
    assert found is not None, selector
    page.mouse.move(found["x"] + x * found["width"], found["y"] + y)
    settle(page)
    return page.locator("#tip").inner_text() if page.locator("#tip").is_visible() else ""


def test_the_pointer_is_told_what_is_under_it(page: Page) -> None:
    page.evaluate("clew.seek(12.6); clew.draw()")
    found = page.evaluate("""(() => {
      const [{ view, canvas }] = clew.panes, { width, height } = canvas.getBoundingClientRect();
      const at = ([x, y]) => (([px, py]) => [px / width, py])(view.toScreen(x, y));
      const robot = clew.frame()[1];
      const [obstacle, goal, ground] = [at([2.2, 0.95]), at([5.5, 2.1]), at([0.1, 0.1])];
      return { robot: at([robot.x, robot.y]), obstacle, goal, ground };
    })()""")
    said = {name: said_at(page, "#panes canvas", *place) for name, place in found.items()}
    assert said["robot"].startswith("robot 2, which leads: driving\n")
    assert said["obstacle"].startswith("obstacle 1: circle, radius 0.22 m\nnearest robot: r")
    assert said["goal"] == "goal, reached within 0.15 m"
    assert said["ground"].startswith("x 0.1")
    assert said_at(page, "#lanes", 0.5, 10.0).startswith("step 4 of r2: ")
    wide = "document.querySelector('#lanes').clientWidth"
    killed = page.evaluate(f"clew.lanes.x(3.0, {wide}) / {wide}")
    assert "3.00 s ϟ kill" in said_at(page, "#lanes", killed, 30.0)
    assert said_at(page, "#lanes", 0.5, 66.0).startswith("robot 1: dead, 3.")
    assert said_at(page, "#charts canvas", 0.5, 50.0).split(" s")[0].replace(".", "").isdecimal()
    least = page.evaluate("""(() => {
      const [chart] = clew.charts, { clientWidth: width, clientHeight: height } = chart.canvas;
      const { curve } = chart.series[3];
      return [chart.x(curve.leastAt, width) / width, chart.y(curve.least, height)];
    })()""")
    assert " s · r4: 0.1" in said_at(page, "#charts canvas", *least)


def test_lanes_and_charts_show_one_part_of_the_time(page: Page) -> None:
    shown_s = "[clew.span.from, clew.span.to]"
    whole = page.evaluate(shown_s)
    page.evaluate("clew.seek(12)")
    page.keyboard.press("i")
    near = page.evaluate(shown_s)
    assert near[1] - near[0] == pytest.approx(whole[1] / 2)
    assert near[0] < 12 < near[1]
    for chart in ("clew.lanes", "clew.charts[0]", "clew.charts[1]"):
        ends = page.evaluate(f"[clew.span.from, clew.span.to].map((t) => {chart}.x(t, 1000))")
        assert ends[0] in (40, 64)
        assert 960 <= ends[1] <= 990
    page.keyboard.press(".")
    assert page.evaluate(shown_s)[0] == pytest.approx(near[0] + whole[1] / 4)
    page.keyboard.press("Home")
    assert page.evaluate(shown_s)[0] == 0
    found = page.locator("#lanes").bounding_box()
    assert found is not None
    page.keyboard.down("Shift")
    page.mouse.move(found["x"] + 300, found["y"] + 100)
    page.mouse.down()
    page.mouse.move(found["x"] + 500, found["y"] + 100)
    page.mouse.up()
    page.keyboard.up("Shift")
    settle(page)
    assert page.evaluate(shown_s)[1] - page.evaluate(shown_s)[0] < 4
    page.locator("#time-whole").click()
    settle(page)
    assert page.evaluate(shown_s) == whole
    assert page.locator("#time-whole").is_disabled()


def test_the_map_fits_the_robots_and_follows_one(page: Page) -> None:
    page.evaluate("clew.seek(12); clew.draw()")
    whole = page.evaluate("clew.panes[0].view.scale")
    page.keyboard.press("r")
    page.evaluate("clew.draw()")
    assert page.evaluate("clew.panes[0].view.scale") > 1.2 * whole
    seen = """clew.frame().every(({ x, y }) => {
      const { view } = clew.panes[0], [px, py] = view.toScreen(x, y);
      return px > 0 && py > 0 && px < view.width && py < view.height;
    })"""
    assert page.evaluate(seen)
    page.keyboard.press("3")
    page.locator("#map-watch").click()
    for t_s in (12, 16):
        page.evaluate(f"clew.seek({t_s}); clew.draw()")
        middle = "[clew.panes[0].view.x, clew.panes[0].view.y]"
        assert page.evaluate(middle) == page.evaluate("[clew.frame()[2].x, clew.frame()[2].y]")
    page.keyboard.press("f")
    page.evaluate("clew.draw()")
    assert page.locator("#map-watch").get_attribute("aria-pressed") == "false"
    assert page.evaluate("clew.panes[0].view.scale") == whole
    page.keyboard.press("l")
    assert "certified ground of a step" in page.locator("#legend").inner_text()
    page.keyboard.press("l")
    assert not page.locator("#legend").is_visible()


def test_the_inspector_says_what_a_robot_does_and_knows(page: Page, run: Path) -> None:
    assert not page.locator("#inspector").is_visible()
    t_s = 12.6
    page.evaluate(f"clew.seek({t_s}); clew.choose(3); clew.draw()")
    lines = timeline.read(run).lines
    said = dict(
        zip(
            page.locator("#inspector dt").all_inner_texts(),
            page.locator("#inspector dd").all_inner_texts(),
            strict=True,
        )
    )
    before = [(source, entry.t_s, entry.record) for source, entry in lines if entry.t_s <= t_s]
    order_s, order = next(
        (at_s, record)
        for _, at_s, record in reversed(before)
        if isinstance(record, OrderAccepted) and record.robot == 3 and record.target is not None
    )
    assert order.target is not None
    to = f"({order.target.x_m:.2f}, {order.target.y_m:.2f})"
    assert said["last order"].startswith(f"{order.number} to {to}, ")
    assert f"{t_s - order_s:.1f} s ago" in said["last order"]
    granted_s, granted = next(
        (at_s, record)
        for source, at_s, record in reversed(before)
        if isinstance(record, AuthorityGranted) and (source, record.to) == ("r2", 3)
    )
    assert said["ahead"].startswith("r2: up")
    assert said["ahead"].endswith(f"{granted.authority_m:.2f} m granted, {t_s - granted_s:.1f} s ago")
    assert said["strand"] == "2 of 4, epoch 20002, turn 1"
    assert said["knows"].startswith("epoch 20002, rank 1 of 4, ")


def test_the_inspector_says_what_the_newest_plan_is_for(page: Page, run: Path) -> None:
    plan_s, plan = next(
        (entry.t_s, entry.record)
        for source, entry in timeline.read(run).lines
        if source == "r2" and isinstance(entry.record, StepPlanned) and not entry.record.joins
    )
    page.evaluate(f"clew.seek({plan_s + 0.01}); clew.choose(2); clew.draw()")
    said = page.locator("#inspector dt", has_text="last plan").locator("xpath=following-sibling::dd[1]")
    assert plan.promised_clearance_m is not None
    assert plan.cost_to_go_m is not None
    assert said.inner_text().startswith(
        f"step {plan.step}: {plan.length_m:.2f} m at {math.degrees(plan.heading_rad):.0f}°, promises "
        f"{plan.promised_clearance_m:.3f} m, leaves a cost-to-go of {plan.cost_to_go_m:.2f} m; "
        f"{len(plan.obstacles)} obstacles, {len(plan.gaps)} gaps seen, 0.0 s ago"
    )


def test_the_map_of_a_moment_and_the_run_are_saved(page: Page) -> None:
    page.evaluate("clew.seek(12.6); clew.draw()")
    page.evaluate("document.querySelector('#save').open = true")

    def saved(kind: str) -> tuple[str, bytes]:
        with page.expect_download() as waited:
            page.locator(f"[data-save={kind}]").click()
        return waited.value.suggested_filename, waited.value.path().read_bytes()

    name, svg = saved("svg")
    assert name == "grove-seed1-12.60s.svg"
    drawing = ET.fromstring(svg.decode())
    words = [each.text for each in drawing.iter("{http://www.w3.org/2000/svg}text")]
    assert {"1", "12", "1 m", "grove, seed 1  ·  t = 12.60 s  ·  step 4"} <= set(words)
    name, png = saved("png")
    assert (name, png[:4]) == ("grove-seed1-12.60s.png", b"\x89PNG")
    page.evaluate("window.whole = clew.runs[0].end; clew.runs[0].end = 0.3")
    name, film = saved("webm")
    page.evaluate("clew.runs[0].end = window.whole; document.querySelector('#save').open = false")
    assert (name, film[:4]) == ("grove-seed1.webm", b"\x1aE\xdf\xa3")  # the mark of Matroska


def test_the_list_searches_all_entries_and_opens_one_as_it_stands_in_the_log(page: Page, run: Path) -> None:
    moments = page.locator("#moments li").count()
    page.locator("#kinds").select_option("order.refused")
    page.locator("#search").fill("Refused void")
    log = [json.loads(line) for line in (run / EVENTS_FILE).read_bytes().splitlines()]
    refused = [each for each in log if each["kind"] == "order.refused"]
    assert page.locator("#moments li").count() == len(refused) > 1
    assert page.locator("#moments-about").inner_text() == f"{len(refused)} found"
    page.locator("#moments .raw").last.click()
    raw = json.loads(page.locator("#moments pre").inner_text())
    assert raw == {name: value for name, value in refused[-1].items() if name not in {"n", "hlc"}}
    page.locator("#moments time").last.click()
    assert page.evaluate("clew.time") == refused[-1]["t_s"]
    page.locator("#search").fill("r2 no such word")
    assert page.locator("#moments li").count() == 0
    page.locator("#search").fill("")
    page.locator("#kinds").select_option("")
    assert page.locator("#moments li").count() == moments


def test_what_the_run_was_asked_for_is_in_the_page(page: Page, run: Path) -> None:
    assert page.locator("#asked summary").all_inner_texts() == ["scenario.toml", "faults.toml"]
    scenario, plan = page.locator("#asked pre").all_text_contents()
    assert tomllib.loads(scenario) == tomllib.loads((run / "scenario.toml").read_text(encoding="utf-8"))
    assert msgspec.toml.decode(plan, type=Plan).rules == read_plan(run).rules


def test_fifty_robots_have_a_lane_each_and_numbers_that_do_not_cover_each_other(shown: Sight) -> None:
    """This test adds robots to the page."""
    queue = [
        {"robot": robot, "t": [0, 30_000], "x": [100 * robot, 0], "y": [500, 0], "heading": [0, 0]}
        for robot in range(6, 51)
    ]
    shown.page.evaluate(f"clew.take(0, {{ tracks: {json.dumps(queue)} }})")
    shown.wait("document.documentElement.style.getPropertyValue('--map') === '210px'")
    settle(shown.page)
    settle(shown.page)
    assert box(shown.page, "#lanes")["height"] <= box(shown.page, "#lanes-scroll")["height"]
    assert box(shown.page, "#panes canvas")["bottom"] <= box(shown.page, "#timeline")["y"]
    shown.page.evaluate("clew.seek(20); clew.draw()")
    shown.page.evaluate("document.querySelector('#save').open = true")
    with shown.page.expect_download() as waited:
        shown.page.locator("[data-save=svg]").click()
    drawing = ET.fromstring(waited.value.path().read_bytes())
    words = [each for each in drawing.iter("{http://www.w3.org/2000/svg}text") if each.get("stroke") is None]
    row = [
        float(each.attrib["x"])
        for each in words
        if (each.text or "").isdecimal() and int(each.text or "") > 12
    ]
    assert len(row) >= 8
    assert min(right - left for left, right in pairwise(sorted(row))) > 14.0


def test_the_head_says_why_a_run_failed_and_leads_to_the_moment(shown: Sight) -> None:
    """This test comes last because it changes the page."""
    page = shown.page
    for reason, link, t_s, robot in (
        (
            "S1 (clearance) broken by robot 2 at t=2.1 s: nearer to an obstacle than promised",
            "t=2.1 s",
            2.14,
            2,
        ),
        ("robot 1 died at t=3.0 s (known at t=3.9 s), and nobody had asked for it", "t=3.9 s", DEATH_S, 1),
        ("4 of 5 living robots arrived", "t=2", None, 0),
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
