"""Several fleets of real processes on one ground: they cross, one loses a robot, one run ends by Ctrl-C."""

import json
import math
import os
import signal
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest

from protocol.faults.manual_faults import FaultRequest, request_fault
from protocol.faults.rules import Kill
from protocol.files.toml_text import toml_text
from tests.support.campaigns import clew
from tests.support.processes.fleets import Fleet, wait_until
from tests.support.stages.fleets import fleet as crew
from tests.support.stages.fleets import raw

# North comes to the crossing 3 s before. Of two that meet there neither is promised a way (docs/fleets.md).
CROSSING = raw(
    crew("east", (1.2, 2.2, 0.0), (5.8, 2.2)),
    crew("north", (4.0, 1.2, math.pi / 2), (4.0, 5.3), robots=3),
    bounds={"x_m_min": 0.0, "y_m_min": 0.0, "x_m_max": 6.5, "y_m_max": 6.0},
)


@pytest.fixture
def fleet(tmp_path: Path) -> Iterator[Fleet]:
    (tmp_path / "crossing.toml").write_text(toml_text(CROSSING))
    fleet = Fleet(tmp_path)
    yield fleet
    fleet.destroy()


def first(fleet: Fleet, name: str, **said: object) -> dict[str, Any]:
    """The first entry of one of the fleets that says this."""

    def look() -> dict[str, Any] | None:
        path = fleet.folder() / name / "events.jsonl"
        lines = path.read_text(encoding="utf-8").splitlines(keepends=True) if path.exists() else []
        entries = [json.loads(line) for line in lines if line.endswith("\n")]
        return next((each for each in entries if said.items() <= each.items()), None)

    return wait_until(look)


def test_two_fleets_cross_and_arrive_and_a_robot_that_is_killed_holds_up_neither(fleet: Fleet) -> None:
    fleet.start("crossing.toml", "--speed", "max")
    first(fleet, "north", kind="strand.formed")
    request_fault(fleet.folder() / "north", FaultRequest(rule=Kill(target="r3")))
    outcome = fleet.end()
    assert outcome.code == 0, outcome.err
    said = fleet.verdict()
    assert said["ok"]
    assert {name: each["robots_arrived"] for name, each in said["fleets"].items()} == {"east": 2, "north": 2}
    assert 0.0 < said["between_m_min"] < 1.0
    lost = json.loads((fleet.folder() / "north" / "verdict.json").read_bytes())
    assert [death["robot"] for death in lost["deaths"]] == [3]
    kept = json.loads((fleet.folder() / "east" / "verdict.json").read_bytes())
    assert (kept["violations"], kept["deaths"], kept["messages"]["unaccounted"]) == (0, [], 0)
    assert fleet.leftovers() == []
    for name in ("east", "north"):
        assert clew("log", "check", fleet.folder() / name).exit_code == 0
        assert clew("replay", fleet.folder() / name).exit_code == 0
    judged = clew("judge", fleet.folder())
    assert judged.exit_code == 0, judged.stdout
    assert judged.stdout.splitlines()[-1] == "OK: 2 fleets, 0 contacts between them"


def test_ctrl_c_ends_all_fleets_with_their_verdicts(fleet: Fleet) -> None:
    launcher = fleet.start("crossing.toml")
    for name in ("east", "north"):
        first(fleet, name, kind="strand.formed")
    launcher.send_signal(signal.SIGINT)
    outcome = fleet.end()
    assert outcome.code == 130, outcome.err
    assert fleet.verdict()["exit_code"] == 130
    assert {each["exit_code"] for each in fleet.verdict()["fleets"].values()} == {130}
    assert fleet.leftovers() == []


def test_a_world_of_several_fleets_that_is_killed_ends_the_run(fleet: Fleet) -> None:
    fleet.start("crossing.toml")
    first(fleet, "east", kind="strand.formed")
    os.kill(fleet.process("world"), signal.SIGKILL)
    outcome = fleet.end()
    assert outcome.code == 128 + signal.SIGKILL, outcome.err
    assert not fleet.verdict()["ok"]
    assert list(fleet.folder().glob("*/faults.at")) == []
    assert fleet.leftovers() == []
