from pathlib import Path

import msgspec
import pytest

from clew.log import timeline
from clew.log.check import Finding, check, sentences
from clew.log.completeness import Completeness
from clew.log.log import Log
from clew.rehearsal.recorded import rehearse
from protocol.errors import UsageError
from protocol.faults.plan import load as load_plan
from protocol.fence import NUMBERS
from protocol.run_settings import SCENARIO_FILE
from protocol.timeline import PoseSampled, PromiseBroken, Record
from protocol.timeline.invariants import INVARIANTS
from tests.support.campaigns import clew
from tests.support.logs.logs import AT_REST, numbered, recorded
from tests.support.strands import driving, strand
from world.record.recorder import EVENTS_FILE
from world.scenario.scenario import load


def found(folder: Path, records: tuple[tuple[str, Record], ...]) -> Finding:
    return check(timeline.read(recorded(folder, numbered(records))))


def test_a_run_without_motion_keeps_every_promise(tmp_path: Path) -> None:
    finding = found(tmp_path / "run", AT_REST)
    assert finding.ok
    assert finding.violations_by_invariant == dict.fromkeys(INVARIANTS, 0)
    assert finding.separation_m_min == pytest.approx(0.1)  # paper.toml's spacing; its robots are points
    assert sentences(finding)[-1].startswith("kept: ")


def test_pose_in_an_obstacle_breaks_clearance_and_authority(tmp_path: Path) -> None:
    in_obstacle_2 = PoseSampled(robot=1, x_m=1.02, y_m=0.432, heading_rad=0.0)
    finding = found(tmp_path / "run", (*AT_REST[:-1], ("world", in_obstacle_2), AT_REST[-1]))
    assert not finding.ok
    assert finding.violations_by_invariant["S1"] >= 1
    assert finding.violations_by_invariant["S3"] >= 1
    assert any("S1 (clearance), robot 1" in sentence for sentence in sentences(finding))


def test_a_log_with_a_hole_is_not_ok_even_if_no_promise_was_broken(tmp_path: Path) -> None:
    finding = found(tmp_path / "run", AT_REST[:-1])
    assert not finding.ok
    assert finding.violations == 0
    assert sentences(finding)[-1].startswith("not proved: ")


def test_a_log_without_the_poses_of_one_body_proves_nothing(tmp_path: Path) -> None:
    """Its entries are numbered without a hole. Where a body is unknown, no distance is."""
    unseen = [each for each in AT_REST if not (isinstance(each[1], PoseSampled) and each[1].robot == 2)]
    finding = found(tmp_path / "run", tuple(unseen))
    assert finding.separation_m_min is None
    assert finding.flaws == ("the judge failed: no distance was judged: robot 2 was never sampled",)


def test_a_log_that_the_judge_cannot_judge_is_not_ok_and_says_why(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def fail(*_: object) -> None:
        raise KeyError("no such robot")

    monkeypatch.setattr("world.judge.truth.truth.Truth.hear", fail)
    finding = found(tmp_path / "run", AT_REST)
    assert not finding.ok
    assert any(flaw.startswith("the judge failed: KeyError: 'no such robot'") for flaw in finding.flaws)


def test_a_header_without_a_valid_scenario_is_refused(tmp_path: Path) -> None:
    read = timeline.read(recorded(tmp_path / "run", numbered(AT_REST)))
    header = msgspec.structs.replace(read.header, scenario={"name": "paper"})
    with pytest.raises(UsageError, match="the scenario in the header cannot be read"):
        check(timeline.Timeline(header, read.lines, read.flaws))


def test_a_header_that_cannot_be_judged_by_is_refused_with_its_file(tmp_path: Path) -> None:
    run = recorded(tmp_path / "run", numbered(AT_REST))
    events = run / EVENTS_FILE
    events.write_bytes(events.read_bytes().replace(b'"robots":', b'"robots":-', 1))
    said = clew("log", "check", run)
    assert (said.exit_code, said.stderr.count("\n")) == (2, 1)
    assert said.stderr.startswith(f"Error: {events}: line 1: the scenario in the header cannot be")


def test_a_log_with_another_scenario_than_the_one_that_was_run_is_not_ok(tmp_path: Path) -> None:
    read = timeline.read(recorded(tmp_path / "run", numbered(AT_REST)))
    scenario = read.header.scenario | {"name": "another"}
    edited = msgspec.structs.replace(read.header, scenario=scenario)
    finding = check(timeline.Timeline(edited, read.lines, read.flaws))
    assert not finding.ok
    assert any("its hash differs" in flaw for flaw in finding.flaws)


def test_a_recorded_violation_that_the_poses_do_not_show_is_not_ok(tmp_path: Path) -> None:
    broken = PromiseBroken(invariant="S1", robot=2, measured_m=0.0, required_m=0.1, why="near")
    finding = found(tmp_path / "run", (*AT_REST[:-1], ("world", broken), AT_REST[-1]))
    assert not finding.ok
    assert any("S1 (clearance), robot 2: recorded as broken" in flaw for flaw in finding.flaws)


def test_a_log_with_two_swapped_lines_of_a_source_is_not_ok(tmp_path: Path) -> None:
    read = timeline.read(recorded(tmp_path / "run", numbered(AT_REST)))
    completeness = Completeness()
    for source, entry in (read.lines[1], read.lines[0], *read.lines[2:]):
        completeness.hear(source, entry)
    assert [flaw for flaw in completeness.flaws() if "comes after" in flaw]


def test_a_log_without_its_header_is_judged_by_the_scenario_in_the_runs_folder(tmp_path: Path) -> None:
    folder = tmp_path / "run"
    rehearse(load("grove", robots=2), 1, folder, lambda _: None, load_plan("loss-50"))
    log = folder / EVENTS_FILE
    whole = check(Log(folder))
    log.write_bytes(log.read_bytes().partition(b"\n")[2])
    headless = check(Log(folder))
    assert (whole.ok, headless.ok) == (True, False)
    assert headless.clearance_m_min == whole.clearance_m_min
    assert [flaw for flaw in headless.flaws if not flaw.startswith("line 1 is damaged")] == []


def test_a_scenario_that_was_changed_after_the_run_began_is_found(tmp_path: Path) -> None:
    folder = tmp_path / "run"
    rehearse(load("grove", robots=2), 1, folder, lambda _: None)
    kept = folder / SCENARIO_FILE
    kept.write_text(kept.read_text().replace('name = "grove"', 'name = "another"'))
    (flaw,) = check(Log(folder)).flaws
    assert flaw.endswith("scenario.toml: was changed after the run had begun")


@pytest.mark.long
def test_a_run_with_thousands_of_views_is_judged(tmp_path: Path) -> None:
    order = (1, 2, 3, 4, 5)
    told: list[tuple[str, Record]] = []
    for generation in range(1, 3_001):
        order = order[::-1]
        told += strand(generation * NUMBERS + order[0], *order)
    finding = found(tmp_path / "run", (*AT_REST[:-1], *told, AT_REST[-1]))
    assert finding.violations == 0
    assert finding.ended == "interrupted"


def test_a_motion_out_of_turn_and_a_skipped_turn_break_the_invariants_of_fences(tmp_path: Path) -> None:
    pushed = PoseSampled(robot=1, x_m=0.0, y_m=0.001, heading_rad=0.0)
    told = (*strand(NUMBERS + 1, 1, 2, 3, 4, 5), driving(NUMBERS + 1, 1, 2, 3, 4, 5, number=3))
    finding = found(tmp_path / "run", (*AT_REST[:-1], ("world", pushed), *told, AT_REST[-1]))
    assert not finding.ok
    counts = finding.violations_by_invariant
    assert (counts["F3"], counts["S3"]) == (3, 2)  # nor was it sampled on its way
    assert any("F3 (one mover), robot 1: moved in turn 0 of epoch 0" in each for each in sentences(finding))
