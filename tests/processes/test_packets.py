"""Whole fleets whose packets are lost, refused or held back: that costs time, and never clearance."""

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
# 17 s of the run, 4 s of ours, where nothing goes wrong
GROVE, SETTINGS = load("grove", robots=ROBOTS), Settings(seed=1, speed=4.0)
LOSS = drop(0.1)  # of all packets that go one way
RESET = "meta l4proto tcp counter reject with tcp reset"
RESETS = 10  # all connections, and as many attempts to come back


@pytest.fixture
def between() -> Iterator[Wire]:
    try:
        with wire() as between:
            yield between
    except UnavailableError as error:
        pytest.skip(f"no network namespaces here: {error}")


@pytest.fixture
def world(fleet: Fleet, between: Wire) -> Iterator[subprocess.Popen[str]]:
    """Of a fleet that has begun to move, its robots at the far end of the wire."""
    with parts(fleet, between).started() as world:
        fleet.wait_for("step.planned")
        yield world


def parts(fleet: Fleet, between: Wire) -> Parts:
    near, far = between.near.command, between.far.command
    return Parts(fleet, ROBOTS, GROVE, SETTINGS, ENDPOINT, ENDPOINT, near=near, far=far)


def verdict(fleet: Fleet, world: subprocess.Popen[str]) -> dict[str, Any]:
    """How the run ended; what holds whatever was lost has been checked."""
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
    """Until a token has gone, and its robot has been silent for another second: some 2 s."""
    fleet.wait_for("robot.died")


def await_resets(between: Wire) -> None:
    """Until connections have been refused for a moment."""

    def enough() -> bool | None:
        (count,) = re.findall(r"counter packets (\d+)", between.far.run("nft", "list", "ruleset"))
        return int(count) >= RESETS or None

    wait_until(enough)


def test_random_loss_both_ways_costs_nothing_but_time(
    fleet: Fleet, between: Wire, world: subprocess.Popen[str]
) -> None:
    between.far.suffer(chains(entering=LOSS, leaving=LOSS))
    assert verdict(fleet, world)["ok"], said(fleet)


@pytest.mark.parametrize(
    "rules", [chains(entering="drop"), chains(leaving="drop")], ids=["deaf robots", "mute robots"]
)
def test_fleet_arrives_after_packets_went_one_way_only(
    fleet: Fleet, between: Wire, world: subprocess.Popen[str], rules: str
) -> None:
    between.far.suffer(rules)
    await_given_up(fleet)
    between.far.suffer("")
    verdict(fleet, world)


def test_fleet_arrives_after_its_link_was_down(
    fleet: Fleet, between: Wire, world: subprocess.Popen[str]
) -> None:
    between.cut()
    await_given_up(fleet)
    between.mend()
    verdict(fleet, world)


def test_fleet_arrives_after_its_connections_were_reset(
    fleet: Fleet, between: Wire, world: subprocess.Popen[str]
) -> None:
    between.far.suffer(chains(leaving=RESET))
    await_resets(between)
    between.far.suffer("")
    verdict(fleet, world)


def break_off(fleet: Fleet) -> list[str]:
    """What the network namespaces were called that a test has broken off in."""
    with contextlib.suppress(KeyboardInterrupt), wire() as between:
        inodes = [between.near.inode(), between.far.inode()]
        with parts(fleet, between).started():
            fleet.wait_for("step.planned")
            assert [holders(inode) == [] for inode in inodes] == [False, False]
            raise KeyboardInterrupt
    return inodes


@pytest.mark.usefixtures("between")  # skips where there are none
def test_no_namespace_and_no_process_is_left_behind_by_a_test_that_breaks_off(fleet: Fleet) -> None:
    inodes = break_off(fleet)
    assert fleet.processes() == {}
    assert [holders(inode) for inode in inodes] == [[], []]
