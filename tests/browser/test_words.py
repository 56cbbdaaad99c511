"""The page's words and figures about moving obstacles, dead robots and unknown values."""

from pathlib import Path

import pytest
from playwright.sync_api import Browser

from clew.fleet.summary import verdict_sentence
from clew.log import timeline
from clew.log.check import scenario_of
from tests.support.pages.browser import Sight, sight
from tests.support.pages.pages import page_of
from tests.support.runs import Runs
from world.record.recorder import EVENTS_FILE
from world.record.run_files import read_verdict


@pytest.fixture(scope="module")
def killed(runs: Runs, tmp_path_factory: pytest.TempPathFactory) -> Path:
    return runs.copy(tmp_path_factory.mktemp("words") / "run", "grove", faults="leader-killed")


def show(shown: Sight, run: Path) -> None:
    """The address of a new report of the run."""
    page = run / "shown.html"
    page.write_text(page_of(run), encoding="utf-8")
    shown.page.goto(page.as_uri())
    shown.page.evaluate("clew.opened")
    shown.page.evaluate("clew.draw()")


def text(shown: Sight, selector: str) -> str:
    return shown.page.locator(selector).inner_text()


def test_the_nearest_obstacle_may_be_a_moving_one(browser: Browser, runs: Runs, tmp_path: Path) -> None:
    run = runs.copy(tmp_path / "run", "pedestrian")
    with sight(browser) as shown:
        show(shown, run)
        least_m = read_verdict(run).moving_clearance_m_min
        assert least_m is not None
        assert f"{least_m:.4f} m" in text(shown, "#figures")
        shown.page.evaluate("clew.seek(clew.runs[0].passing.leastAt); clew.draw()")
        said = text(shown, "#robot-now")
        assert said.startswith("nearest to a moving obstacle: robot ")
        assert float(said.split(", ")[1].split()[0]) <= least_m + 0.001
        assert shown.troubles == []


def test_runs_with_moving_obstacles_have_a_separate_chart_of_passings(
    browser: Browser, runs: Runs, killed: Path, tmp_path: Path
) -> None:
    with sight(browser) as shown:
        show(shown, runs.copy(tmp_path / "run", "pedestrian"))
        chart = shown.page.locator(".chart", has_text="To moving obstacles")
        assert chart.is_visible()
        assert f"least {read_verdict(tmp_path / 'run').moving_clearance_m_min:.4f} m" in chart.inner_text()
        show(shown, killed)
        assert not chart.is_visible()


def test_a_curve_that_leaves_the_chart_at_the_top_is_marked(browser: Browser, killed: Path) -> None:
    with sight(browser) as shown:
        show(shown, killed)
        assert "▴ > 0." in shown.page.locator(".chart", has_text="Separation").inner_text()


def test_an_empty_chart_appears_with_its_first_values(browser: Browser, killed: Path) -> None:
    with sight(browser) as shown:
        show(shown, killed)
        canvas = shown.page.locator(".chart", has_text="Messages lost").locator("canvas")
        assert not canvas.is_visible()
        shown.page.evaluate("clew.take(0, { losses: { t: [1000], sender: [1], receiver: [2] } })")
        canvas.wait_for()


def test_a_dead_robot_has_no_distance_to_obstacles(browser: Browser, killed: Path) -> None:
    with sight(browser) as shown:
        show(shown, killed)
        shown.page.evaluate("clew.runs[0].body(1).clearance.push(4, 0.001); clew.seek(6); clew.draw()")
        assert "robot 1," not in text(shown, "#robot-now")
        assert "nearest" in text(shown, "#robot-now")


def test_values_missing_from_a_damaged_header_are_shown_as_not_known(
    browser: Browser, killed: Path, tmp_path: Path
) -> None:
    header, rest = (killed / EVENTS_FILE).read_bytes().split(b"\n", 1)
    (tmp_path / EVENTS_FILE).write_bytes(header[:300] + b"\n" + rest)
    (tmp_path / "empty").mkdir()
    with sight(browser) as shown:
        for run in (tmp_path, tmp_path / "empty"):
            show(shown, run)
            said = text(shown, "body")
            assert "not known" in said
            for guess in ("seed 0", "above 0", "only one robot", "no fixed obstacle"):
                assert guess not in said
        assert shown.troubles == []


def test_a_law_without_a_promise_is_named_with_its_shortfall(
    browser: Browser, runs: Runs, tmp_path: Path
) -> None:
    run = runs.copy(tmp_path / "run", "paper")
    sentence = verdict_sentence(read_verdict(run), scenario_of(timeline.read(run)))
    short = sentence.split("this is ")[1].split(" short of")[0]
    with sight(browser) as shown:
        show(shown, run)
        said = text(shown, "#verdict")
        assert "Kept its promises" not in said
        assert f"Clearance {read_verdict(run).clearance_m_min:.4f} m: --law printed promises none" in said
        assert f"this is {short} short of" in said


def test_a_step_that_promises_too_little_names_the_reason(browser: Browser, killed: Path) -> None:
    with sight(browser) as shown:
        show(shown, killed)
        assert "leads away from" not in text(shown, "#steps-about")
        away = "{ ...clew.runs[0].steps[0].row, promised_m: 0, leads_away: true }"
        shown.page.evaluate(f"clew.take(0, {{ steps: [{away}] }})")
        shown.wait("document.querySelector('#steps-about').innerText.includes('leads away from')")
        assert "0.000 *" in text(shown, "#steps")


def test_the_folder_of_a_run_is_named(browser: Browser, killed: Path) -> None:
    with sight(browser) as shown:
        show(shown, killed)
        assert f"in {killed.name}" in text(shown, "#facts")


def test_the_end_of_a_run_is_neither_a_fault_nor_a_recovery(browser: Browser, killed: Path) -> None:
    with sight(browser) as shown:
        show(shown, killed)
        last = shown.page.locator("#moments li").last.locator("i")
        assert last.get_attribute("class") == "row3"


def test_a_live_page_shows_robots_at_their_last_known_places(browser: Browser, killed: Path) -> None:
    with sight(browser) as shown:
        show(shown, killed)
        shown.page.evaluate("""
          clew.run = new clew.runs[0].constructor();
          const track = { robot: 2, t: [8000, 300], x: [0, 100], y: [0, 0], heading: [0, 0] };
          clew.run.take({ tracks: [track], end_s: 8.64 });
          clew.run.goTo(8.3);
        """)
        assert shown.page.evaluate("[clew.run.newest, clew.run.body(2).isMoving]") == [8.3, True]
        shown.page.evaluate("clew.run.take({ end_s: 12 }); clew.run.goTo(clew.run.newest)")
        assert shown.page.evaluate("[clew.run.newest, clew.run.body(2).isMoving]") == [11.5, False]
