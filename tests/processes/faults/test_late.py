"""Real fleets in which processes are stopped or ended by somebody, not by a fault plan."""

import os
import signal
from typing import Any

from tests.support.processes.fleets import Fleet, wait_until


def entries(fleet: Fleet, kind: str) -> list[dict[str, Any]]:
    return [entry for entry in fleet.entries() if entry["kind"] == kind]


def pid_of(fleet: Fleet, robot: str) -> int:
    """The process id of a robot, as it has recorded it."""
    return next(int(each["pid"]) for each in entries(fleet, "robot.started") if each["source"] == robot)


def test_a_robot_that_was_stopped_for_long_holds_nobody_for_lost(fleet: Fleet) -> None:
    fleet.start("grove", "-n", "3", "--speed", "2", "--json")
    fleet.wait_for("step.planned")
    judge = pid_of(fleet, "r2")
    os.kill(judge, signal.SIGSTOP)
    fleet.wait_for("robot.died")
    healed = wait_until(lambda: entries(fleet, "strand.healed") or None)[-1]
    os.kill(judge, signal.SIGCONT)
    outcome = fleet.end()
    assert {entry["robot"] for entry in entries(fleet, "robot.died")} == {2}, "nobody else was declared dead"
    broken = entries(fleet, "link.broken")
    assert [entry for entry in broken if entry["source"] == "r2"] == []
    assert {entry["neighbour"] for entry in broken if entry["t_s"] <= healed["t_s"]} <= {2}
    verdict = fleet.verdict()
    assert (verdict["violations"], verdict["robots_arrived"]) == (0, 3), outcome.err


def test_a_robot_that_somebody_has_ended_is_reported_as_that_and_not_as_its_hosts_death(fleet: Fleet) -> None:
    fleet.start("grove", "-n", "3", "--speed", "2", "--json")
    fleet.wait_for("step.planned")
    os.kill(pid_of(fleet, "r3"), signal.SIGTERM)
    outcome = fleet.end()
    assert "robot 3 was ended by SIGTERM" in outcome.err
    assert "the host" not in outcome.err
    verdict = fleet.verdict()
    assert (outcome.code, verdict["exit_code"], verdict["robots_arrived"]) == (1, 1, 2)
    assert verdict["reason"].startswith("robot 3 died")
