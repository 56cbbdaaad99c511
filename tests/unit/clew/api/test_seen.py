"""`run.seen`: what a law was given, found by replay, so that it can be asked again when its run is over."""

import re
from pathlib import Path

import numpy as np
import pytest

import clew
from agents.navigation.laws import certified, printed
from clew.log.law_asked import chosen
from protocol import laws
from tests.support.campaigns import clew as clew_verb
from tests.support.runs import Runs


@pytest.fixture(scope="module")
def grove(runs: Runs) -> clew.Run:
    """To read."""
    return clew.open(runs.of("grove"))


@pytest.fixture(scope="module")
def succeeded(runs: Runs) -> clew.Run:
    """To read: the leader dies when it has planned its second step, which its successor then plans, too."""
    return clew.open(runs.of("grove", faults="killed-after-plan"))


def test_the_law_proposes_the_recorded_step_again(grove: clew.Run) -> None:
    assert len(grove.steps) > 2
    for step in grove.steps:
        again = certified(grove.seen(step.number))
        assert isinstance(again, clew.Step)
        assert (again.heading_rad, again.length_m) == (step.plan.heading_rad, step.plan.length_m)
        assert again.cost_to_go_m in {None, step.plan.cost_to_go_m}


def test_a_law_of_the_paper_proposes_the_recorded_step_again(runs: Runs) -> None:
    run = clew.open(runs.of("paper"))
    again = printed(run.seen(10))
    assert isinstance(again, clew.Step)
    assert again.length_m == run.steps[9].plan.length_m
    assert "it aims at a gap of " in chosen(run.seen(10), run.steps[9].plan)


def test_another_law_can_be_asked_what_it_would_have_done(grove: clew.Run) -> None:
    seen = grove.seen(1)
    assert isinstance(printed(seen), clew.Step)
    assert np.isfinite(seen.cost_to_go_m(seen.position[None])).all()


def test_without_a_step_it_is_what_the_law_was_given_last_as_where_the_route_was_lost(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(laws, "_registered", {})
    asked: list[tuple[float, ...]] = []

    def gives_up(seen: clew.Seen) -> clew.Step | str:
        asked.append(tuple(seen.position.tolist()))
        return certified_once(seen) if seen.steps == 0 else "enough"

    def certified_once(seen: clew.Seen) -> clew.Step:
        step = certified(seen)
        assert isinstance(step, clew.Step)
        return step

    clew.register_law("gives-up", gives_up)
    run = clew.rehearse("grove", robots=2, law="gives-up", out=tmp_path / "run")
    assert run.entries("route.lost")
    last = asked[-1]
    seen = run.seen()
    assert seen.steps == 1
    assert tuple(seen.position.tolist()) == last
    assert laws._registered == {"gives-up": gives_up}, "the law itself is asked from then on"
    why = clew_verb("log", "why", str(run.folder), "route.lost")
    assert why.exit_code == 0
    [said] = [line for line in why.stdout.splitlines() if " r1 law " in line]
    assert re.search(r"gives-up: the goal is \d\.\d{3} m off at .* of that are certified; ", said)
    assert re.search(r"the longest certified step is \d\.\d{3} m, at .* rad; the map has a way, with", said)


def test_the_path_leads_from_the_last_place_of_the_strand_over_all_steps_to_the_leader(
    grove: clew.Run,
) -> None:
    first = grove.seen(1).path
    for step in grove.steps:
        seen = grove.seen(step.number)
        assert (seen.path[0] == first[0]).all()
        assert seen.path[-1] == pytest.approx(seen.position, abs=seen.mission.mu0_m)
        earlier = [grove.seen(number).position for number in range(1, step.number)]
        off_m = [np.hypot(*(seen.path - place).T).min() for place in earlier]
        assert max(off_m, default=0.0) < seen.mission.mu0_m, "each former switching position is a corner"


def test_in_a_notebook_it_is_a_line(grove: clew.Run) -> None:
    seen = grove.seen(2)
    assert repr(seen).startswith(f"<clew.Seen from ({seen.position[0]:.3f}, {seen.position[1]:.3f}), goal (")
    assert repr(seen).endswith(" obstacles, 1 steps planned before>")


def test_a_step_that_nobody_planned_is_refused(grove: clew.Run) -> None:
    with pytest.raises(clew.UsageError, match=r"^seen: no leader has planned step 99$"):
        grove.seen(99)
    with pytest.raises(clew.UsageError, match=r"^seen: r2 has never planned step 1$"):
        grove.seen(1, robot=2)


def test_a_step_that_two_leaders_planned_needs_the_robot(succeeded: clew.Run) -> None:
    with pytest.raises(clew.UsageError, match=r"r1 and r2 have planned step 2: say which, as robot=\.\.\."):
        succeeded.seen(2)
    assert (succeeded.seen(2, robot=1).position != succeeded.seen(2, robot="r2").position).any()


def test_without_journals_nothing_is_known(tmp_path: Path, runs: Runs) -> None:
    run = runs.copy(tmp_path / "run", "grove")
    for journal in (run / "inputs").iterdir():
        journal.unlink()
    with pytest.raises(clew.UsageError, match=r"no journal has the decision of r1 at t=\d"):
        clew.open(run).seen(1)
