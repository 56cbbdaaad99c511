"""Whole fleets whose packets are lost, refused or delayed. This costs time, but never clearance."""

import contextlib
import re
import subprocess
from collections.abc import Iterator
from typing import Any

import pytest

from protocol.run_settings import Settings
from tests.support.deadline import DEADLINE_S
from tests.support.processes.fleets import Fleet, wait_until
from tests.support.processes.netns import ADDRESS, UnavailableError, Wire, chains, drop, holders, wire
from tests.support.processes.parts import Parts, said
from world.scenario.scenario import load

ROBOTS = 3
ENDPOINT = f"tcp/{ADDRESS}:7447"
# without faults: 17 s of simulated time in 4 s of wall time
GROVE, SETTINGS = load("grove", robots=ROBOTS), Settings(seed=1, speed=4.0)
LOSS = drop(0.1)  # of all packets in one direction
RESET = "meta l4proto tcp counter reject with tcp reset"
RESETS = 10  # all connections, and as many attempts to reconnect


@pytest.fixture
def between() -> Iterator[Wire]:
    try:
        with wire() as between:
            yield between
    except UnavailableError as error:
        pytest.skip(f"no network namespaces here: {error}")


@pytest.fixture
def world(fleet: Fleet, between: Wire) -> Iterator[subprocess.Popen[str]]:
    """A fleet that has begun to move, with its robots at the far end of the wire."""
    with parts(fleet, between).started() as world:
        fleet.wait_for("step.planned")
        yield world


def parts(fleet: Fleet, between: Wire) -> Parts:
    near, far = between.near.command, between.far.command
    return Parts(fleet, ROBOTS, GROVE, SETTINGS, ENDPOINT, ENDPOINT, near=near, far=far)


def verdict(fleet: Fleet, world: subprocess.Popen[str]) -> dict[str, Any]:
    """How the run ended; checks everything that must hold despite the losses."""
    world.wait(DEADLINE_S)
    read = fleet.verdict()
    assert read["violations"] == 0, said(fleet)
    assert (read["robots_arrived"], read["goal_reached"]) == (ROBOTS, True), said(fleet)
    assert read["events"]["missing"] == 0
    messages = read["messages"]
    assert messages["left_out"] == []
    assert (messages["injected"], messages["refused"]) == ({}, 0)
    assert messages["sent"] == messages["received"] + messages["unaccounted"]
    return read


def await_given_up(fleet: Fleet) -> None:
    """Wait until a token has vanished and its robot was silent for one more second: about 2 s."""
    fleet.wait_for("robot.died")


def await_resets(between: Wire) -> None:
    """Wait until connections have been refused for a moment."""

    def enough() -> bool | None:
        (count,) = re.findall(r"counter packets (\d+)", between.far.run("nft", "list", "ruleset"))
        return int(count) >= RESETS or None

    wait_until(enough)


def test_random_loss_in_both_directions_costs_only_time(
    fleet: Fleet, between: Wire, world: subprocess.Popen[str]
) -> None:
    between.far.suffer(chains(entering=LOSS, leaving=LOSS))
    assert verdict(fleet, world)["ok"], said(fleet)


@pytest.mark.parametrize(
    "rules", [chains(entering="drop"), chains(leaving="drop")], ids=["deaf robots", "mute robots"]
)
def test_fleet_arrives_after_an_outage_in_one_direction(
    fleet: Fleet, between: Wire, world: subprocess.Popen[str], rules: str
) -> None:
    between.far.suffer(rules)
    await_given_up(fleet)
    between.far.suffer("")
    verdict(fleet, world)


def test_fleet_arrives_after_a_link_outage(fleet: Fleet, between: Wire, world: subprocess.Popen[str]) -> None:
    between.cut()
    await_given_up(fleet)
    between.mend()
    verdict(fleet, world)


def test_fleet_arrives_after_connection_resets(
    fleet: Fleet, between: Wire, world: subprocess.Popen[str]
) -> None:
    between.far.suffer(chains(leaving=RESET))
    await_resets(between)
    between.far.suffer("")
    verdict(fleet, world)


def break_off(fleet: Fleet) -> list[str]:
    """The names of the network namespaces of a test that was aborted."""
    with contextlib.suppress(KeyboardInterrupt), wire() as between:
        inodes = [between.near.inode(), between.far.inode()]
        with parts(fleet, between).started():
            fleet.wait_for("step.planned")
            assert [holders(inode) == [] for inode in inodes] == [False, False]
            raise KeyboardInterrupt
    return inodes


@pytest.mark.usefixtures("between")  # skips if there are no namespaces
def test_an_aborted_test_leaves_no_namespace_and_no_process_behind(fleet: Fleet) -> None:
    inodes = break_off(fleet)
    assert fleet.processes() == {}
    assert [holders(inode) for inode in inodes] == [[], []]
