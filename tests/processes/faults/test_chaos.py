"""Live chaos: what counts as trouble, how leftovers are found, and one real fleet that passes."""

import json
import os
import signal
import subprocess
import sys
from collections.abc import Iterator
from dataclasses import replace as changed
from itertools import count
from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st
from msgspec.structs import replace

from clew.campaign.chaos import (
    ChaosRun,
    fleet_in,
    has_arrived,
    is_balanced,
    judge_run,
    not_recovered,
    replay_line,
    sum_up,
    troubles_of,
)
from clew.campaign.liveness import at_end, liveness_failure
from clew.fleet.live import Ended, left_behind, processes_of, run_fleet
from clew.log.check import Finding, check
from clew.log.completeness import LAST_MISSING
from clew.log.timeline import Timeline, read
from clew.rehearsal.rehearsal import Rehearsal
from clew.swarm.swarm import Mode, draw
from clew.swarm.world import Ground
from protocol.faults.plan import Plan
from protocol.faults.rules import Partition
from protocol.timeline import RunEnded
from tests.support.campaigns import clew
from tests.support.deadline import DEADLINE_S
from tests.support.logs.logs import AT_REST, GOOD, HEADER, PAPER, numbered, recorded
from tests.support.processes.fleets import Fleet, wait_until
from world.judge.books import Messages
from world.judge.ending import Ending

WELL = Ended(code=0, said=("ok",), wall_s=1.0, leftovers=())
COUNTS = st.integers(0, 10**6)
LIVELY = next(
    swarm
    for swarm in map(draw, count(1))
    if (swarm.mode, swarm.ground) == (Mode.LIVENESS, Ground.OPEN) and len(swarm.scenario.fleet.poses()) > 2
)


@pytest.fixture
def finding(tmp_path: Path) -> Finding:
    """The finding for a log in which every promise was kept."""
    return check(read(recorded(tmp_path, numbered(AT_REST))))


@pytest.fixture
def sleeper(tmp_path: Path) -> Iterator[subprocess.Popen[bytes]]:
    """A process that has a fleet's temporary folder in its environment and keeps running."""
    command = [sys.executable, "-c", "import sys; print('here', flush=True); sys.stdin.read()"]
    environment = {**os.environ, "TMPDIR": str(tmp_path)}
    pipe = subprocess.PIPE
    with subprocess.Popen(command, env=environment, stdin=pipe, stdout=pipe) as process:
        assert process.stdout is not None
        process.stdout.readline()  # Linux shows no environment of a process that has just started
        yield process
        process.kill()


def test_a_run_that_kept_its_promises_and_left_nothing_has_no_troubles(finding: Finding) -> None:
    assert list(troubles_of(GOOD, finding, WELL)) == []


def test_each_broken_promise_is_a_separate_trouble(finding: Finding) -> None:
    broken = replace(GOOD, violations=2, violations_by_invariant={"S1": 0, "S2": 2})
    assert list(troubles_of(broken, finding, WELL)) == ["broken: S2 (separation) 2"]
    off = replace(GOOD, messages=replace(GOOD.messages, unaccounted=-1))
    assert list(troubles_of(off, finding, WELL)) == ["the message counts do not balance"]
    unheard = replace(GOOD, events=replace(GOOD.events, missing=6))
    assert list(troubles_of(unheard, finding, WELL)) == []  # interrupted: they may have been cut off
    arrived = replace(finding, ended="every living robot has arrived")
    assert list(troubles_of(unheard, arrived, WELL)) == ["6 entries of the timeline are missing"]
    torn = replace(finding, ok=False, flaws=("line 3 is torn",))
    assert list(troubles_of(GOOD, torn, WELL)) == ["log check: 0 violations; line 3 is torn"]
    mute = replace(finding, ok=False, flaws=(f"r2: {LAST_MISSING}",))
    assert list(troubles_of(GOOD, mute, WELL)) == []  # likewise
    mute = replace(mute, ended="every living robot has arrived")
    assert list(troubles_of(GOOD, mute, WELL)) == [f"log check: 0 violations; r2: {LAST_MISSING}"]
    left = Ended(code=0, said=(), wall_s=1.0, leftovers=("python -m agents",))
    assert list(troubles_of(GOOD, finding, left)) == ["left behind: python -m agents"]
    refused = Ended(code=2, said=("fleet.sh: no such plan",), wall_s=1.0, leftovers=())
    assert list(troubles_of(GOOD, finding, refused)) == ["the launcher refused: fleet.sh: no such plan"]
    hung = Ended(code=None, said=(), wall_s=1.0, leftovers=())
    assert list(troubles_of(None, None, hung)) == [
        "the launcher did not end when it was asked to",
        "there is no verdict",
        "the log cannot be read",
    ]


@given(COUNTS, st.dictionaries(st.sampled_from(["drop", "corrupt"]), COUNTS), COUNTS, COUNTS)
def test_message_counts_balance_exactly_when_every_sent_message_is_accounted_for(
    received: int, injected: dict[str, int], refused: int, lost: int
) -> None:
    sent = received + sum(injected.values()) + refused + lost
    books = Messages(
        sent=sent, received=received, injected=injected, refused=refused, unaccounted=lost, left_out=()
    )
    assert is_balanced(books)
    assert not is_balanced(replace(books, received=received + 1))
    assert not is_balanced(
        replace(books, received=sent + 1, unaccounted=-1 - sum(injected.values()) - refused)
    )


def test_a_folder_without_a_run_is_judged_and_quotes_the_launchers_last_line(tmp_path: Path) -> None:
    ended = Ended(code=1, said=("clew: the world was killed",), wall_s=1.0, leftovers=())
    run = judge_run(draw(3), tmp_path, ended, replay="again", load=1.0)
    assert (run.reason, run.arrived, run.messages) == ("clew: the world was killed", False, None)
    assert run.troubles == ("there is no verdict", "the log cannot be read")


def test_a_fleet_that_says_it_has_arrived_has_not_if_poses_do_not_show_it() -> None:
    said = Timeline(HEADER, tuple(numbered((*AT_REST[:-1], ("world", RunEnded(reason=Ending.ARRIVED))))), ())
    told, lied = (fleet_in(said, PAPER, untrue=untrue) for untrue in (frozenset[int](), frozenset({1})))
    assert told is not None
    assert lied is not None
    assert has_arrived(told, said.lines, outside=frozenset())
    assert not has_arrived(lied, said.lines, outside=frozenset())


def test_a_run_that_was_ended_from_outside_tells_nothing_of_its_fleet() -> None:
    for reason in ("interrupted", "another process of the run was lost"):
        told = Timeline(HEADER, tuple(numbered((*AT_REST[:-1], ("world", RunEnded(reason=reason))))), ())
        assert fleet_in(told, PAPER, untrue=frozenset()) is None


@pytest.fixture(scope="module")
def cut_off() -> Rehearsal:
    """A run in which one robot is cut off from the others to the end, so that not all arrive."""
    cut = Partition(group=("r1",), from_s=0.5)
    return Rehearsal(LIVELY.scenario, LIVELY.seed, Plan(name="cut", rules=(cut,))).run()


def test_a_log_shows_that_a_fleet_did_not_recover_just_as_its_rehearsal_does(cut_off: Rehearsal) -> None:
    log = Timeline(HEADER, tuple(cut_off.entries), ())
    read_back = fleet_in(log, LIVELY.scenario, untrue=frozenset())
    assert read_back is not None
    told, seen = (
        liveness_failure(fleet, cut_off.entries, quiet_s=1.0, outside=frozenset())
        for fleet in (read_back, at_end(cut_off.world))
    )
    assert told == seen is not None
    lively = changed(LIVELY, quiet_s=1.0, outside=frozenset())
    assert not_recovered(read_back, cut_off.entries, lively) == told
    assert not_recovered(read_back, cut_off.entries, changed(lively, mode=Mode.SAFETY)) is None


def test_a_summary_is_ok_only_if_complete_and_without_trouble(tmp_path: Path) -> None:
    bad = judge_run(draw(3), tmp_path, WELL, replay="again", load=1.0)
    good = fine(bad)
    assert sum_up([good, good], asked=2, speed="2", interrupted=False).ok
    assert not sum_up([good], asked=2, speed="2", interrupted=True).ok
    mixed = sum_up([good, bad], asked=2, speed="2", interrupted=False)
    assert (mixed.ok, mixed.unbalanced, mixed.not_arrived) == (False, 1, 1)
    assert mixed.messages_sent == GOOD.messages.sent


def fine(run: ChaosRun) -> ChaosRun:
    return replace(run, troubles=(), messages=GOOD.messages, arrived=True)


def test_the_replay_line_names_what_was_drawn() -> None:
    said = replay_line(Path("c/drawn/7.toml"), 7, "2")
    assert said == "./launch/fleet.sh c/drawn/7.toml --faults c/drawn/7.faults.toml --seed 7 --speed 2"


def test_a_leftover_process_is_named_and_killed(tmp_path: Path, sleeper: subprocess.Popen[bytes]) -> None:
    assert list(processes_of(tmp_path)) == [sleeper.pid]
    (tmp_path / "socket").touch()
    process, file = left_behind(tmp_path)
    assert process.startswith(sys.executable)
    assert file == "socket"
    assert sleeper.wait(DEADLINE_S) == -9
    assert processes_of(tmp_path) == {}


def test_a_folder_that_is_not_empty_is_refused_before_a_fleet_starts_and_left_unchanged(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("clew.verbs.chaos.run_fleet", no_fleet)
    former = recorded(tmp_path / "run-3", numbered(AT_REST)) / "events.jsonl"
    before = former.read_bytes()
    told = clew("chaos", "--runs", "1", "--seed", "3", "--out", tmp_path)
    assert (told.exit_code, told.stdout) == (2, "")
    said = f"Error: {tmp_path}: is not empty; a run needs a new or an empty folder\n"
    assert told.stderr == said
    assert [path for path in tmp_path.rglob("*") if path.is_file()] == [former]
    assert former.read_bytes() == before


def no_fleet(*_: object, **__: object) -> Ended:
    raise AssertionError("a fleet was started")


def test_a_fleet_that_is_asked_to_end_ends_and_leaves_nothing(tmp_path: Path) -> None:
    out = tmp_path / "run"
    has_begun = (out / "events.jsonl").exists
    ended = run_fleet(["grove", "--out", str(out)], wall_s_max=DEADLINE_S, until=has_begun)
    assert (ended.code, ended.leftovers) == (143, ())
    assert ended.wall_s < DEADLINE_S


def test_chaos_that_is_asked_to_end_stops_its_fleet_reports_it_and_leaves_nothing(fleet: Fleet) -> None:
    chaos = fleet.start_with(sys.executable, "-m", "clew.cli", "chaos", "--speed", "1", "--out", "ch")
    wait_until(lambda: (fleet.cwd / "ch" / "run-1" / "events.jsonl").exists() or None)
    for _ in range(2):  # `timeout` sends the signal twice, too
        chaos.send_signal(signal.SIGTERM)
    outcome = fleet.end()  # the launcher's promise, and as much for the verb; a run takes longer
    assert (outcome.code, fleet.leftovers()) == (143, [])
    assert "INTERRUPTED: 0 of 50 runs" in outcome.out
    assert json.loads((fleet.cwd / "ch" / "chaos.json").read_text(encoding="utf-8"))["interrupted"]


def test_chaos_runs_a_fleet_through_a_case_drawn_by_its_seed_and_reports_it(tmp_path: Path) -> None:
    told = clew("chaos", "--runs", "1", "--speed", "8", "--out", tmp_path / "out", "--json")
    assert told.exit_code == 0, told.output
    said = json.loads(told.stdout)
    assert json.loads((tmp_path / "out" / "chaos.json").read_text(encoding="utf-8")) == said
    (run,) = said["each"]
    assert run["troubles"] == []
    assert (said["ok"], said["runs"]) == (True, 1)
    assert run["classes"] == [str(each) for each in draw(1).classes]
    assert (tmp_path / "out" / "drawn" / "1.faults.toml").exists()
