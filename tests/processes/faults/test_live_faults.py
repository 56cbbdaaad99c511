"""Real fleets and real signals: faults during a run, and what the run reports about them."""

import json
import os
import subprocess
import sys
from pathlib import Path
from typing import Any

import pytest

from clew.rehearsal.logbook import NTP64_PER_S
from protocol.root import ROOT
from tests.support.campaigns import clew
from tests.support.deadline import DEADLINE_S
from tests.support.long import long
from tests.support.processes.fleets import Fleet


def plan(folder: Path, *rules: str) -> str:
    path = folder / "plan.toml"
    path.write_text('name = "test"\n' + "".join(f"[[rule]]\n{rule}\n" for rule in rules))
    return str(path)


def run(fleet: Fleet, *rules: str, robots: int = 3, speed: str = "max") -> dict[str, Any]:
    """The verdict of a run under these rules; checks that it ended by itself and left nothing behind."""
    asked = ("-n", str(robots), "--speed", speed, "--json", "--faults", plan(fleet.cwd, *rules))
    outcome = fleet.run("grove", *asked)
    verdict: dict[str, Any] = json.loads(outcome.out)
    assert verdict["violations"] == 0
    assert fleet.leftovers() == []
    assert (outcome.code, verdict["ok"]) == (0, True), verdict["reason"]
    return verdict


def kinds(fleet: Fleet, kind: str) -> list[dict[str, Any]]:
    return [entry for entry in fleet.entries() if entry["kind"] == kind]


def clew_fault(fleet: Fleet, *arguments: str) -> subprocess.CompletedProcess[str]:
    """Run `clew fault` on the fleet's run."""
    command = [sys.executable, "-m", "clew.cli", "fault", str(fleet.folder()), *arguments]
    environment = {**os.environ, "PYTHONPATH": str(ROOT)}
    return subprocess.run(
        command,
        cwd=fleet.cwd,
        env=environment,
        capture_output=True,
        text=True,
        timeout=DEADLINE_S,
        check=False,
    )


def test_a_leader_killed_by_a_plan_is_replaced_and_the_run_is_ok(fleet: Fleet) -> None:
    verdict = run(fleet, 'fault = "kill"\ntarget = "leader"\nfrom_s = 3.0')
    (death,) = verdict["deaths"]
    assert (death["ordered"], death["cause_s"]) == (True, 3.0)
    assert 3.0 < death["detected_s"] <= death["recovered_s"]
    (succession,) = verdict["successions"]
    assert (succession["before"], succession["cause_s"]) == (death["robot"], 3.0)
    assert verdict["robots_arrived"] == 2


def test_a_restarted_robot_is_a_new_process_that_counts_from_one_and_arrives(
    fleet: Fleet,
) -> None:
    restart = 'fault = "restart"\ntarget = "r3"\nfrom_s = 3.0\nafter_s = 1.0'
    # The duplicate is noted before the new process has its mission, yet its log begins with `robot.started`.
    verdict = run(fleet, restart, 'fault = "duplicate"\nkind = ["mission"]')
    started = [entry for entry in kinds(fleet, "robot.started") if entry["source"] == "r3"]
    assert [entry["n"] for entry in started] == [1, 1]
    assert started[0]["pid"] != started[1]["pid"]
    assert [entry["robot"] for entry in kinds(fleet, "robot.restarted")] == [3]
    assert (verdict["robots_arrived"], verdict["events"]["missing"]) == (3, 0)


def test_a_frozen_robot_that_is_thawed_rejoins_and_arrives(fleet: Fleet) -> None:
    verdict = run(fleet, 'fault = "freeze"\ntarget = "leader"\nfrom_s = 3.0\nfor_s = 5.0')
    assert [entry["fault"] for entry in kinds(fleet, "fault.injected")] == ["freeze", "thaw"]
    assert len(kinds(fleet, "robot.returned")) == 1
    assert (len(verdict["deaths"]), verdict["robots_arrived"]) == (1, 3)


def test_a_robot_that_stays_frozen_is_thawed_at_the_end_and_exits(fleet: Fleet) -> None:
    verdict = run(fleet, 'fault = "freeze"\ntarget = "tail"\nfrom_s = 3.0')
    assert verdict["robots_arrived"] == 2


def test_a_robot_frozen_and_killed_between_plan_and_order_has_recorded_only_the_plan(fleet: Fleet) -> None:
    tail = 'fault = "kill"\ntarget = "tail"\nfrom_s = 1.0'  # an earlier injection elsewhere changes nothing
    point = 'target = "leader"\npoint = "after_plan"\noccurrence = 2'
    freeze, kill = f'fault = "freeze"\nfor_s = 600.0\n{point}', f'fault = "kill"\n{point}'
    verdict = run(fleet, tail, freeze, kill, robots=4)
    assert verdict["unstruck"] == []
    (struck,) = [entry for entry in kinds(fleet, "fault.injected") if entry["rule"] == "kill-3"]
    planned, frozen, killed = [e for e in fleet.entries() if e["source"] == struck["source"]][-3:]
    assert (planned["kind"], frozen["rule"], killed) == ("step.planned", "freeze-2", struck)
    robot = int(struck["source"][1:])
    ordered = [
        (entry["epoch"], entry["step"]) for entry in kinds(fleet, "order.accepted") if entry["robot"] == robot
    ]
    assert (planned["epoch"], planned["step"]) not in ordered


def test_every_message_fault_is_recorded_and_the_message_counts_balance(
    fleet: Fleet,
) -> None:
    verdict = run(
        fleet,
        'fault = "drop"\nprobability = 0.2',
        'fault = "corrupt"\nprobability = 0.05',
        'fault = "duplicate"\nprobability = 0.2\ndelay_s_max = 0.1',
        'fault = "delay"\ndelay_s_max = 0.05',
        robots=2,
        speed="5",
    )
    messages = verdict["messages"]
    injected = kinds(fleet, "fault.injected")
    assert {entry["fault"] for entry in injected} == {"drop", "corrupt", "duplicate", "delay"}
    assert messages["injected"].keys() == {"drop", "corrupt"}
    assert messages["sent"] == messages["received"] + sum(messages["injected"].values())
    assert (messages["refused"], messages["unaccounted"]) == (0, 0)
    lost = [entry for entry in injected if entry["fault"] == "drop" and entry["number"]]
    assert len({(entry["source"], entry["key"], entry["number"]) for entry in lost}) == len(lost)
    assert len(lost) >= messages["injected"]["drop"] > 0


def test_an_unplanned_kill_of_a_robot_makes_the_run_fail(fleet: Fleet) -> None:
    fleet.start("grove", "-n", "3", "--speed", "5", "--json")
    fleet.wait_for("step.planned")
    (victim,) = [entry["pid"] for entry in kinds(fleet, "robot.started") if entry["source"] == "r3"]
    os.kill(victim, 9)
    outcome = fleet.end()
    verdict = json.loads(outcome.out)
    assert (outcome.code, verdict["ok"]) == (1, False)
    assert verdict["reason"].startswith("robot 3 died at t=")
    assert verdict["reason"].endswith("and nobody had asked for it")
    assert fleet.leftovers() == []


def test_clew_fault_strikes_a_running_fleet_and_refuses_a_finished_one(fleet: Fleet) -> None:
    # At this speed it ends when it is told to, not before.
    launcher = fleet.start("grove", "-n", "3", "--speed", "0.1", "--json")
    fleet.wait_for("step.planned")
    killed = clew_fault(fleet, "kill", "3")
    assert (killed.returncode, killed.stdout) == (0, "given-1\n"), killed.stderr
    dropped = clew_fault(fleet, "drop", "--from", "r1", "--to", "2", "--probability", "0.5", "--for", "5s")
    assert (dropped.returncode, dropped.stdout) == (0, "given-2\n"), dropped.stderr
    for verb, word in (("log check", "not complete"), ("replay", "robot 1")):
        said = clew(*verb.split(), fleet.folder())
        assert f"{word}" in said.stdout
        assert "the run is still going on" in said.stdout
        assert "did not live" not in said.stdout
        assert "was killed" not in said.stdout
    refused = clew_fault(fleet, "kill", "nobody")
    assert (refused.returncode, refused.stdout) == (2, "")
    assert "must" in refused.stderr
    fleet.wait_for("robot.died")
    launcher.terminate()
    outcome = fleet.end()
    verdict = json.loads(outcome.out)
    assert (outcome.code, [death["ordered"] for death in verdict["deaths"]]) == (143, [True])
    injected = kinds(fleet, "fault.injected")
    assert {(entry["rule"], entry["process"]) for entry in injected if entry["process"]} == {
        ("given-1.r3", "r3")
    }
    struck = {(entry["source"], entry["key"]) for entry in injected if entry["rule"] == "given-2"}
    assert struck <= {("r2", "link/r1/r2"), ("r2", "view/r1/r2")}
    late = clew_fault(fleet, "kill", "1")
    assert late.returncode == 2
    assert "no run goes on there" in late.stderr
    assert fleet.leftovers() == []


def test_an_invalid_plan_is_refused_in_one_line_that_names_the_field(fleet: Fleet) -> None:
    outcome = fleet.run("paper", "--faults", plan(fleet.cwd, 'fault = "drop"\nprobability = 2.0'))
    assert (outcome.code, outcome.err.count("\n")) == (2, 1)
    assert "$.rule[0].probability: must be <= 1.0, got 2.0" in outcome.err
    assert fleet.leftovers() == []


@pytest.mark.parametrize(
    ("name", "rule", "injections"),
    [
        ("world", 'fault = "restart"\nafter_s = 3.0', ["kill", "start"]),
        *long([("router", 'fault = "freeze"\nfor_s = 3.0', ["freeze", "thaw"])]),
    ],
)
def test_world_and_router_return_after_the_outage_that_a_plan_asks_for(
    fleet: Fleet, name: str, rule: str, injections: list[str]
) -> None:
    fleet.start(
        "grove",
        "-n",
        "3",
        "--speed",
        "2",
        "--json",
        "--faults",
        plan(fleet.cwd, f'{rule}\ntarget = "{name}"\nfrom_s = 3.0'),
    )
    outcome = fleet.end()
    verdict = json.loads(outcome.out)
    assert (outcome.code, verdict["ok"], verdict["robots_arrived"]) == (0, True, 3), verdict["reason"]
    assert [entry["fault"] for entry in kinds(fleet, "fault.injected")] == injections
    assert away_wall_s(fleet) > 1.4, "3 s at twice real time"
    assert fleet.leftovers() == []


def away_wall_s(fleet: Fleet) -> float:
    """Time from the injection to the world's next record of that part, by the world's time stamps."""
    entries = fleet.entries()
    struck = next(place for place, entry in enumerate(entries) if entry["kind"] == "fault.injected")
    back = {"router.found", "world.resumed", "fault.injected"}
    told = next(entry for entry in entries[struck + 1 :] if entry["kind"] in back)
    return stamp_s(told) - stamp_s(entries[struck])


def stamp_s(entry: dict[str, Any]) -> float:
    return int(entry["hlc"].partition("/")[0]) / NTP64_PER_S
