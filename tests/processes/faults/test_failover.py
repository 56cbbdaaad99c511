"""Router failures: the other router takes over, or a new one replaces the dead one. The run continues."""

import json
import os
import signal
from typing import Any

from protocol.timeline import RouterFound, RouterLost
from tests.support.campaigns import clew
from tests.support.processes.fleets import Fleet, wait_until
from world.routing import LOOK_S_MAX, Routing


def pid_of(fleet: Fleet, name: str) -> int:
    """The process that the launcher reports under this name."""
    (private,) = fleet.temporary.glob("clew.*")
    return int((private / f"{name}.pid").read_text())


def new_pid(fleet: Fleet, name: str, before: int) -> int | None:
    """The process of this name, if it is a new one."""
    pid = pid_of(fleet, name)
    return None if pid == before else pid


def end_well(fleet: Fleet) -> dict[str, Any]:
    """The verdict of a successful run; checks its log again and that nothing is left behind."""
    outcome = fleet.end()
    assert outcome.code == 0, outcome.err
    verdict: dict[str, Any] = json.loads(outcome.out)
    assert (verdict["ok"], verdict["violations"], verdict["events"]["missing"]) == (True, 0, 0)
    assert (verdict["deaths"], verdict["robots_arrived"]) == ([], 3)
    assert clew("log", "check", fleet.folder()).exit_code == 0
    assert fleet.leftovers() == []
    return verdict


def test_the_second_router_takes_over_when_the_active_one_is_killed(fleet: Fleet) -> None:
    fleet.start("grove", "-n", "3", "--speed", "2", "--routers", "2", "--json")
    fleet.wait_for("order.finished")
    first = pid_of(fleet, "router")
    assert first == pid_of(fleet, "router-1")
    os.kill(first, signal.SIGKILL)
    wait_until(lambda: new_pid(fleet, "router-1", first))
    wait_until(lambda: pid_of(fleet, "router") == pid_of(fleet, "router-2") or None)
    end_well(fleet)
    kinds = [entry["kind"] for entry in fleet.entries()]
    assert (kinds.count("router.lost"), kinds.count("router.found")) == (1, 1)


def test_a_killed_router_is_restarted_and_the_run_continues(fleet: Fleet) -> None:
    fleet.start("grove", "-n", "3", "--speed", "max", "--json")
    fleet.wait_for("order.finished")
    os.kill(fleet.process("protocol"), signal.SIGKILL)
    end_well(fleet)
    assert "router.found" in {entry["kind"] for entry in fleet.entries()}


def test_an_immediate_failover_is_reported_as_lost_and_found() -> None:
    routing = Routing()
    said = [list(routing.look(router, wall_s=wall_s)) for wall_s, router in enumerate(["a", "a", "b", "b"])]
    assert said == [[], [], [RouterLost(), RouterFound(away_s=1.0)], []]


def test_a_router_that_stays_down_is_reported_lost_once() -> None:
    routing = Routing()
    said = [list(routing.look(router, wall_s=at)) for at, router in enumerate(["a", None, None, "a"])]
    assert said == [[], [RouterLost()], [], [RouterFound(away_s=3.0)]]
    assert routing.away_s(9.0) == 0.0


def test_while_the_world_is_frozen_no_router_stays_away() -> None:
    routing = Routing()
    assert list(routing.look("a", wall_s=5.0)) == []
    assert list(routing.look(None, wall_s=105.0)) == [RouterLost()]
    assert routing.away_s(105.0) == LOOK_S_MAX
    assert list(routing.look(None, wall_s=106.0)) == []
    assert routing.away_s(106.0) == LOOK_S_MAX + 1.0
