"""`clew log diff`: the first difference of two runs."""

import json
import re
from pathlib import Path

import msgspec
import pytest
from click.testing import CliRunner, Result

from clew.cli import main
from clew.log.diff import CONTEXT, NO_DIFFERENCE_OF_STEPS, first_difference, headers_apart, steps_of
from protocol.timeline import PoseSampled, RobotStarted, RouterFound, RunEnded, StepFinished
from tests.support.logs.logs import AT_REST, HEADER, numbered, recorded
from tests.support.runs import Runs
from world.record.lines import Line
from world.record.recorder import EVENTS_FILE

LINES = numbered(AT_REST)


def clew(*arguments: str | Path) -> Result:
    return CliRunner().invoke(main, [str(argument) for argument in arguments])


def moved(lines: list[Line], row: int, **changes: float) -> list[Line]:
    """The same lines, one of them otherwise."""
    source, entry = lines[row]
    changed = msgspec.structs.replace(entry, record=msgspec.structs.replace(entry.record, **changes))
    return [*lines[:row], (source, changed), *lines[row + 1 :]]


@pytest.fixture(scope="module")
def twins(runs: Runs, tmp_path_factory: pytest.TempPathFactory) -> tuple[Path, Path, Path]:
    """Two rehearsals of one seed, and one of another."""
    same = tmp_path_factory.mktemp("rehearsals") / "same"
    assert clew("rehearse", "grove", "--seed", "1", "--out", same).exit_code == 0
    return runs.of("grove"), same, runs.of("grove", seed=2)


def test_two_rehearsals_of_one_seed_are_the_same(twins: tuple[Path, Path, Path]) -> None:
    one, same, _ = twins
    for by in ("entry", "step"):
        said = clew("log", "diff", one, same, "--by", by)
        assert (said.exit_code, said.stdout, said.stderr) == (0, "the same\n", "")
    assert json.loads(clew("log", "diff", one, same, "--json").stdout) == {
        "same": True,
        "header": [],
        "unread": False,
        "flaws": {"a": [], "b": []},
        "difference": None,
    }


def test_a_rehearsal_with_another_seed_differs_in_its_seed_and_in_an_entry(
    twins: tuple[Path, Path, Path],
) -> None:
    one, _, other = twins
    said = clew("log", "diff", one, other)
    assert said.exit_code == 1
    first, second, *rest = said.stdout.splitlines()
    assert first == "the runs were started differently: seed"
    assert "first difference" in second
    assert {line[0] for line in rest} == {" ", "-", "+"}
    names = {re.split(r"[.\[]", name)[0] for name in re.split(", | and ", second.split(": ", 1)[1])}
    differs = next(line for line in rest if line[0] == "-")
    assert set(re.findall(r" (\w+)=", differs)) <= names, "only what differs is printed"
    found = json.loads(clew("log", "diff", one, other, "--json").stdout)
    logs = [(run / EVENTS_FILE).read_text(encoding="utf-8").splitlines()[1:] for run in (one, other)]
    number = found["difference"]["entry"]
    assert not found["same"]
    assert found["difference"]["a"] == json.loads(logs[0][number])
    assert found["difference"]["b"] == json.loads(logs[1][number])
    assert found["difference"]["before"] == [json.loads(line) for line in logs[0][number - CONTEXT : number]]


def test_the_first_different_field_is_named_with_the_entries_around_it() -> None:
    found = first_difference(LINES, moved(LINES, 3, x_m=9.0))
    assert found is not None
    assert (found.entry, found.fields) == (3, ("x_m",))
    assert found.before == tuple(LINES[:3])
    assert found.after_a == found.after_b == tuple(LINES[4:])


def test_a_longer_run_differs_where_the_other_one_has_ended() -> None:
    found = first_difference(LINES, LINES[:-1])
    assert found is not None
    assert (found.entry, found.a, found.b) == (len(LINES) - 1, LINES[-1], None)


def test_clocks_process_ids_and_incarnations_are_ignored() -> None:
    records = (("r1", RobotStarted(pid=1, incarnation="a")), ("world", RouterFound(away_s=0.1)))
    others = (("r1", RobotStarted(pid=2, incarnation="b")), ("world", RouterFound(away_s=0.2)))
    later = [(source, msgspec.structs.replace(entry, hlc="9/9")) for source, entry in numbered(others)]
    assert first_difference(numbered(records), later) is None


def test_times_and_numbers_count_by_entry_but_not_by_step() -> None:
    step = ("world", StepFinished(robot=1, step=3, x_m=0.1, y_m=0.2, clearance_m=0.11))
    early, late = numbered((step, *AT_REST)), numbered((*AT_REST, step))
    assert first_difference(early, late) is not None
    assert first_difference(steps_of(early), steps_of(late), but=NO_DIFFERENCE_OF_STEPS) is None
    found = first_difference(steps_of(early), steps_of(moved(late, -1 + len(late), x_m=0.3)))
    assert found is not None
    assert "x_m" in found.fields


def test_numbers_may_differ_by_the_given_tolerance() -> None:
    pose = next(entry.record for _, entry in LINES if isinstance(entry.record, PoseSampled))
    other = moved(LINES, 0, x_m=pose.x_m + 0.01)
    assert first_difference(LINES, other, within=0.02) is None
    assert first_difference(LINES, other, within=0.005) is not None


def test_different_settings_are_named_but_not_the_names_of_runs() -> None:
    other = msgspec.structs.replace(HEADER, run="another", started_at="later", seed=2)
    assert headers_apart(HEADER, other) == ("seed",)


def test_an_incomplete_log_is_reported(tmp_path: Path) -> None:
    run = recorded(tmp_path / "run", numbered((("world", RunEnded(reason="interrupted")),)))
    with (run / EVENTS_FILE).open("ab") as file:
        file.write(b'{"t_s":1')
    said = clew("log", "diff", run, run)
    assert said.exit_code == 0
    assert "torn" in said.stderr


@pytest.mark.parametrize("by", ["entry", "step"])
def test_runs_with_different_unreadable_lines_are_not_the_same(tmp_path: Path, by: str) -> None:
    one, other = (recorded(tmp_path / name, LINES) for name in ("one", "other"))
    with (other / EVENTS_FILE).open("ab") as file:
        file.write(b"{bad}\n")
    said = clew("log", "diff", one, other, "--by", by)
    assert said.exit_code == 1
    assert said.stdout == "the unreadable lines differ\nno entry differs\n"
    assert said.stderr.startswith(f"b is not complete: line {len(LINES) + 2} cannot be read: ")
    found = json.loads(clew("log", "diff", one, other, "--by", by, "--json").stdout)
    assert (found["same"], found["unread"], found["flaws"]["a"]) == (False, True, [])
    assert len(found["flaws"]["b"]) == 1


def test_unknown_entries_are_compared_except_for_their_clocks(tmp_path: Path) -> None:
    runs = []
    for name, hlc, mood in (("one", 1, "good"), ("later", 2, "good"), ("other", 2, "bad")):
        runs.append(recorded(tmp_path / name, LINES))
        with (runs[-1] / EVENTS_FILE).open("a", encoding="utf-8") as file:
            strange = {
                "t_s": 9.0,
                "hlc": str(hlc),
                "source": "r1",
                "n": 1,
                "kind": "robot.felt",
                "mood": mood,
            }
            file.write(json.dumps(strange) + "\n")
    one, later, other = runs
    assert clew("log", "diff", one, later).exit_code == 0
    assert clew("log", "diff", later, other).exit_code == 1


def test_flaws_after_the_first_difference_are_reported_too(tmp_path: Path) -> None:
    one = recorded(tmp_path / "one", LINES)
    other = recorded(tmp_path / "other", moved(LINES, 0, x_m=9.0)[:-1])
    said = clew("log", "diff", one, other)
    assert said.exit_code == 1
    assert "b is not complete: no run.ended" in said.stderr


def test_no_such_run_is_one_line_and_exit_2(tmp_path: Path) -> None:
    run = recorded(tmp_path / "run", LINES)
    said = clew("log", "diff", run, tmp_path / "nothing")
    assert (said.exit_code, said.stdout, said.stderr.count("\n")) == (2, "", 1)


def test_only_two_different_live_runs_get_the_advice_to_compare_steps(
    tmp_path: Path, twins: tuple[Path, Path, Path]
) -> None:
    one = recorded(tmp_path / "one", LINES)
    other = recorded(tmp_path / "other", moved(LINES, 0, x_m=3.0))
    assert "--by step" in clew("log", "diff", one, other).stderr
    assert "--by step" not in clew("log", "diff", one, other, "--by", "step").stderr
    assert clew("log", "diff", one, one).stderr == ""
    assert clew("log", "diff", twins[0], twins[2]).stderr == ""
