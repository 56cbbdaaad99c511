"""What the tutorials print is what their commands print today."""

from pathlib import Path

import pytest

from tests.support.pages.tutorials import Tutorial, replace


@pytest.fixture(autouse=True)
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """An empty present folder."""
    monkeypatch.chdir(tmp_path)


def test_the_first_scenario_prints_what_its_page_says() -> None:
    page, yard = Tutorial("first-scenario"), "yard.toml"
    page.save(yard)
    page.follow()
    replace(yard, "mu0_m = 0.01 ", "mu0_m = 0.005 ")
    page.follow()
    replace(yard, "mu0_m = 0.005 ", "mu0_m = 0.01 ")
    page.append(yard)
    page.follow()
    replace(yard, "2.45", "2.75")
    page.follow()
    page.append(yard)
    page.pass_over()


def test_the_first_fault_plan_prints_what_its_page_says() -> None:
    page, rough = Tutorial("first-fault-plan"), "rough.toml"
    page.save(rough)
    page.follow()
    page.append(rough)
    for _ in range(2):
        page.follow()
    page.pass_over()
    replace(rough, "probability = 0.33", 'probability = 0.33\nto = ["r9"]')
    page.follow()
    replace(rough, 'to = ["r9"]', "")
    replace(rough, "occurrence = 2", "from_step = 20")
    page.follow()


def test_the_failed_run_prints_what_its_page_says() -> None:
    page = Tutorial("failed-run")
    for _ in range(3):
        page.follow()
    page.end_with("rehearse", "paper", "--law", "certified")
