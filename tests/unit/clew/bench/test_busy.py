"""What counts as well beside busy processes."""

from msgspec.structs import replace

from clew.bench.busy import BusyFigures, busy_run, common
from tests.support.logs.logs import GOOD
from world.judge.recovery import Death

DEATH = Death(
    robot=2, cause_s=1.0, known_s=2.0, ordered=False, detected_s=None, recovered_s=None, returned_s=None
)


def test_a_run_is_well_where_all_arrived_and_nobody_was_held_for_dead() -> None:
    well = busy_run(GOOD, (), launcher_s=9.0)
    assert well.ok
    for worse in (
        replace(GOOD, deaths=(DEATH,)),
        replace(GOOD, violations=1),
        replace(GOOD, robots_arrived=GOOD.robots - 1),
    ):
        assert not busy_run(worse, (), launcher_s=9.0).ok


def test_a_run_without_a_verdict_is_not_well_and_says_what_the_launcher_said() -> None:
    run = busy_run(None, ("one", "the router is not ready"), launcher_s=60.0)
    assert (run.ok, run.reason) == (False, "the router is not ready")


def test_no_runs_are_not_well() -> None:
    assert not BusyFigures(busy=1, cores=2, load=1.0, runs=()).ok


def test_the_common_figures_have_a_repeat_for_each_run() -> None:
    runs = (busy_run(replace(GOOD, deaths=(DEATH,)), (), launcher_s=9.0), busy_run(None, (), launcher_s=60.0))
    dead, missing, speed, _ = common(BusyFigures(busy=1, cores=2, load=1.0, runs=runs))
    assert (dead.measured.most, dead.met, missing.met) == (1, True, True)
    assert (speed.measured.repeats, speed.measured.least) == (2, 0.0)
