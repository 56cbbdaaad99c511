"""A run as an object: what it says is what the log says."""

import shutil
from collections import Counter
from pathlib import Path
from typing import Any

import pytest

from clew.api.run import Run, open_run
from clew.log import timeline
from clew.log.log import Log
from protocol.errors import UsageError
from protocol.timeline import FaultInjected, LeaderSucceeded, MessageRefused, PoseSampled, TrafficCounted
from tests.support.logs.logs import AT_REST, numbered, recorded
from tests.support.runs import Runs
from world.judge.verdict import VERDICT_FILE
from world.record.recorder import EVENTS_FILE

LINES_OF_A_BEGUN_RUN = 400


@pytest.fixture
def run(runs: Runs) -> Run:
    """To read: half of all messages are lost."""
    return open_run(runs.of("grove", faults="loss-50"))


def test_entries_are_those_of_the_log_in_its_order(run: Run) -> None:
    lines = list(Log(run.folder).lines)
    assert [(each.source, each.written) for each in run.entries()] == lines
    chosen = [line for line in lines if 2.0 <= line[1].t_s <= 5.0 and line[0] == "r2"]
    assert [(each.source, each.written) for each in run.entries(source="r2", t=(2.0, 5.0))] == chosen
    assert run.entries(source=2) == run.entries(source="r2")
    assert {each.kind for each in run.entries("step.*")} == {"step.planned", "step.finished"}
    assert {each.kind for each in run.entries(("pose.sampled", "fault.injected"))} == {
        "pose.sampled",
        "fault.injected",
    }


def test_a_step_is_printed_as_a_sentence(runs: Runs) -> None:
    first = open_run(runs.of("grove")).steps[0]
    assert first.end is not None
    target = f"({first.plan.target.x_m:.3f}, {first.plan.target.y_m:.3f})"
    assert str(first) == (
        f"step 1 of r1: planned at t={first.t_s:.3f} s, {first.plan.length_m:.3f} m to {target}; "
        f"finished at t={first.end.t_s:.3f} s, {first.end.clearance_m:.3f} m clear"
    )
    cut = open_run(runs.of("grove", faults="killed-after-plan")).steps[1]
    assert str(cut).startswith("step 2 of r1: planned at ")
    assert "; broken off at t=" in str(cut)
    assert "clear" not in str(cut)


@pytest.mark.parametrize("kind", ["step.planed", "stepp.*", ("step.*", "step.planed")])
def test_a_kind_that_there_is_not_is_refused_with_a_suggestion(run: Run, kind: str | tuple[str, ...]) -> None:
    near = "'step.planned'" if "step.planed" in kind else "'step."
    with pytest.raises(UsageError, match=rf"there is no kind '.*'; did you mean {near}"):
        run.entries(kind)


def test_a_robot_is_a_number_or_a_name_and_one_that_there_is_not_is_refused(run: Run) -> None:
    assert run.entries("robot.settled", robot="r2") == run.entries("robot.settled", robot=2) != []
    assert run.replay("r2") == run.replay(2)
    for nobody in (0, 6, "r6", "robot3", "leader"):
        with pytest.raises(UsageError, match="robot: must be a robot of the fleet, r1 to r5, got "):
            run.entries("robot.died", robot=nobody)


@pytest.mark.parametrize(
    ("choice", "why"),
    [
        ({"source": "wrld"}, "source: must be world, or a robot of the fleet, r1 to r5, got wrld"),
        ({"source": ("world", 6)}, "source: must be world, or a robot of the fleet, r1 to r5, got r6"),
        ({"source": "r*"}, r"source: must be .*, got r\*"),
        ({"rule": "drp-1"}, "rule: must be one of drop-1, got 'drp-1'; did you mean 'drop-1'\\?"),
        ({"rule": ("drop-*", "kill-*")}, r"rule: must be one of drop-1, got 'kill-\*'"),
        ({"key": "typo"}, "key: must be a key of messages in this run, such as .*, got 'typo'"),
        ({"key": ("link/r2/*", "lnk/r1/r2")}, r"key: .*, got 'lnk/r1/r2'; did you mean 'link/r1/r2'\?"),
        ({"key": "link/r2/r6"}, "key: .*, got 'link/r2/r6'; .*"),
        ({"step": "2"}, "step: must be an integer, 0 or more, got '2'"),
        ({"step": -1}, "step: must be an integer, 0 or more, got -1"),
        ({"t": 5.0}, r"t: must be two times, as \(2, 9\), got 5.0"),
        ({"t": (9.0, 2.0)}, "time: must be from an earlier time to a later one, got 9 to 2 s"),
    ],
)
def test_what_no_entry_of_the_run_can_have_is_refused_and_not_answered_with_nothing(
    run: Run, choice: dict[str, Any], why: str
) -> None:
    with pytest.raises(UsageError, match=f"^{why}$"):
        run.entries(**choice)


def test_a_key_on_which_nothing_was_struck_is_answered_with_nothing(run: Run, tmp_path: Path) -> None:
    assert run.entries(key="fault/r1") == []
    garbled = MessageRefused(key="lin{/r1/r2", reason="checksum")
    damaged = open_run(recorded(tmp_path / "damaged", numbered((("r2", garbled),))))
    assert [each.key for each in damaged.entries(key="lin{/*")] == ["lin{/r1/r2"]


def test_a_rule_given_by_hand_may_not_have_struck_yet_and_its_parts_are_suggested(
    run: Run, tmp_path: Path
) -> None:
    assert run.entries(rule="given-1") == []
    struck = FaultInjected(fault="kill", rule="given-1.r3", process="r3")
    given = open_run(recorded(tmp_path / "given", numbered((("world", struck),))))
    with pytest.raises(UsageError, match=r"got 'given-1'; did you mean 'given-1\.r3'\?"):
        given.entries(rule="given-1")
    assert len(given.entries(rule="given-1.*")) == 1


def test_a_run_without_faults_has_no_rules(tmp_path: Path) -> None:
    quiet = open_run(recorded(tmp_path / "quiet", numbered(AT_REST)))
    with pytest.raises(UsageError, match="rule: must be a fault rule, and this run has none, got 'kill-1'"):
        quiet.entries(rule="kill-1")


def test_the_fields_of_an_entry_are_its_attributes(run: Run) -> None:
    [first] = run.entries("step.planned", step=1)
    assert (first.step, first.kind, first.source) == (1, "step.planned", "r1")
    assert first.as_dict()["target"]["x_m"] == first.target.x_m
    assert str(first).startswith(f"t={first.t_s:.3f} s r1: r1 plans step 1")
    assert not hasattr(first, "no_such_field")


def test_of_a_field_that_an_entry_has_not_the_error_names_those_it_has(tmp_path: Path) -> None:
    led = open_run(recorded(tmp_path / "led", numbered((("r2", LeaderSucceeded(epoch=20002, before=1)),))))
    [entry] = led.entries("leader.succeeded")
    why = "^leader.succeeded has no field 'robot', only t_s, source, kind, epoch, before; its source is 'r2'$"
    with pytest.raises(AttributeError, match=why):
        _ = entry.robot


def test_a_run_knows_its_verdict_its_seed_and_its_steps(run: Run) -> None:
    assert run.verdict is not None
    assert (run.ok, run.seed, run.flaws) == (True, 1, ())
    assert len([step for step in run.steps if step.end]) == run.verdict.switching_steps
    assert run.scenario.name == "grove"
    assert repr(run) == f"<clew.Run {run.folder}: {run.sentences[0]}>"


def test_messages_balance_with_the_books_of_the_robots(run: Run) -> None:
    delivered: Counter[str] = Counter()
    lost: Counter[str] = Counter()
    for message in run.messages:
        (delivered if message.fate == "delivered" else lost)[message.key] += 1
    told: Counter[str] = Counter()
    for entry in run.entries("fault.injected"):
        assert isinstance(entry.record, FaultInjected)
        told[str(entry.record.key)] += 1
    assert lost == told
    links = 0
    for entry in run.entries("traffic.counted"):
        assert isinstance(entry.record, TrafficCounted)
        for key, received in entry.record.received.items():
            if key.startswith("link/"):
                links += 1
                assert delivered[key] == received
    assert links == 8


def test_a_moment_is_between_two_samples_and_before_what_comes_later(run: Run) -> None:
    poses = [each for each in run.poses if each.robot == 2]
    one, other = poses[20], poses[21]
    then = run.at((one.t_s + other.t_s) / 2.0)
    assert then.robots[2].x_m == pytest.approx((one.x_m + other.x_m) / 2.0)
    assert then.robots[2].clearance_m == one.clearance_m
    assert then.order == (1, 2, 3, 4, 5)
    assert (then.leader, then.may_move, then.robots[5].place) == (1, "all", 4)
    assert run.at(1e6).robots[1].state == "arrived"


@pytest.mark.parametrize("time", [-1, float("nan"), float("inf"), "last", None])
def test_a_moment_that_is_no_time_of_a_run_is_refused(run: Run, time: object) -> None:
    with pytest.raises(UsageError, match=r"^at: must be .*, got "):
        run.at(time)  # type: ignore[arg-type] # as in a notebook


def test_entries_are_asked_for_by_numbers(run: Run) -> None:
    for times in (("2", "x"), (float("nan"), 9.0)):
        with pytest.raises(UsageError, match=r"^t: must be a time \[simulated s\], got (nan|'x')"):
            run.entries(t=times)  # type: ignore[arg-type] # as in a notebook
    assert len(run.entries(t=(0.0, float("inf")))) == len(run.entries(t=(None, None))) == len(run.entries())


def test_it_judges_replays_and_reports(run: Run, tmp_path: Path) -> None:
    assert run.check().ok
    assert run.replay(2).ok
    assert run.report(tmp_path / "why.html").read_text(encoding="utf-8").startswith("<!doctype html>")
    (tmp_path / "mine.html").write_text("mine")
    with pytest.raises(UsageError, match="bears no mark of Clew"):
        run.report(tmp_path / "mine.html")


def test_in_a_notebook_it_shows_its_verdict_and_its_map(run: Run) -> None:
    shown = run._repr_html_()
    assert "OK: every living robot has arrived" in shown
    assert "<svg" in shown


def test_a_run_that_goes_on_shows_more_with_each_look(run: Run, tmp_path: Path) -> None:
    whole = (run.folder / EVENTS_FILE).read_bytes().splitlines(keepends=True)
    begun = tmp_path / EVENTS_FILE
    begun.write_bytes(b"".join(whole[:LINES_OF_A_BEGUN_RUN]) + whole[LINES_OF_A_BEGUN_RUN][:20])
    growing = open_run(tmp_path)
    assert (len(growing.entries()), growing.verdict, growing.ok) == (LINES_OF_A_BEGUN_RUN - 1, None, False)
    assert "no verdict; recorded up to t=" in repr(growing)
    begun.write_bytes(b"".join(whole))
    assert len(growing.entries()) == len(whole) - 1
    shutil.copy(run.folder / VERDICT_FILE, tmp_path)
    assert growing.ok
    assert growing.flaws == ()


def test_a_damaged_line_is_a_flaw_and_the_rest_is_read(run: Run, tmp_path: Path) -> None:
    whole = (run.folder / EVENTS_FILE).read_bytes().splitlines(keepends=True)
    for name in (EVENTS_FILE, "copy.jsonl"):
        (tmp_path / name).write_bytes(b"".join([*whole[:50], b"garbage\n", *whole[50:]]))
    shutil.copy(run.folder / VERDICT_FILE, tmp_path)
    damaged = open_run(tmp_path)
    assert len(damaged.entries()) == len(whole) - 1
    assert "line 51 cannot be read" in damaged.flaws[0]
    assert open_run(tmp_path / "copy.jsonl").verdict is None  # it may be of another run


def test_no_run_is_refused(tmp_path: Path) -> None:
    with pytest.raises(UsageError, match=f"no run in {tmp_path}"):
        open_run(tmp_path)


def test_an_old_log_without_distances_is_read(run: Run, tmp_path: Path) -> None:
    text = (run.folder / EVENTS_FILE).read_text(encoding="utf-8")
    old = "\n".join(
        line.split(',"clearance_m":')[0] + "}" if "pose.sampled" in line else line
        for line in text.splitlines()
    )
    (tmp_path / EVENTS_FILE).write_text(f"{old}\n")
    poses = open_run(tmp_path).poses
    assert len(poses) == len(run.poses)
    assert isinstance(poses[0].record, PoseSampled)
    assert poses[0].record.clearance_m is None
    assert timeline.read(tmp_path).flaws == ()
