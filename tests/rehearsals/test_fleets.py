"""Fleets that meet on one ground: they never touch, they all arrive, and each premise of that is needed."""

import json
from pathlib import Path

import numpy as np
import pytest
from msgspec.structs import replace

from agents.body.driver import Driver
from agents.navigation.certificate import Walls, scan_walls
from agents.navigation.scan import View, on_ground
from clew.rehearsal.fleets import RecordedFleets
from clew.rehearsal.recorded import Recorded
from protocol.faults.plan import NO_FAULTS, uniform
from protocol.files.toml_text import toml_text
from protocol.mission import Mission
from tests.support.campaigns import clew
from tests.support.long import long
from tests.support.stages.fleets import EAST_M, HEAD_ON, LANE_M, WEST_M, fleet, raw, rehearsed, shared
from world.bodies.sensor import Sensor
from world.scenario.fleets import SharedGround, seed_of

MOVES_S = 4.0  # all strands have formed, and drive
MEET_S = 20.0  # they are 4.6 m apart, and drive at 0.5 m/s


def contacts(recorded: RecordedFleets) -> list[str]:
    return [str(each) for each in recorded.hulls.between.contacts]


def timeline(folder: Path) -> bytes:
    return (folder / "events.jsonl").read_bytes()


def test_two_fleets_that_meet_head_on_pass_each_other_and_arrive(tmp_path: Path) -> None:
    recorded = rehearsed(shared(), tmp_path)
    assert contacts(recorded) == []
    said = json.loads((tmp_path / "verdict.json").read_bytes())
    assert {name: each["robots_arrived"] for name, each in said["fleets"].items()} == {"east": 2, "west": 2}
    assert said["ok"], said["reason"]
    # They did meet.
    assert 0.0 < said["between_m_min"] < 0.2
    for name in ("east", "west"):
        assert json.loads((tmp_path / name / "verdict.json").read_bytes())["violations"] == 0
    judged = clew("judge", str(tmp_path))
    assert judged.exit_code == 0, judged.stdout
    assert judged.stdout.splitlines()[-1] == "OK: 2 fleets, 0 contacts between them"
    assert clew("replay", str(tmp_path / "west")).exit_code == 0


@pytest.mark.parametrize("seed", [1, *long([2])])
def test_fleets_that_meet_do_not_touch_while_a_third_of_all_messages_is_lost(
    tmp_path: Path, seed: int
) -> None:
    crossing = fleet("north", (3.5, 0.5, np.pi / 2), (3.5, 2.6), robots=1)
    ground = shared(*HEAD_ON, crossing)
    recorded = rehearsed(ground, tmp_path, seed=seed, plan=uniform(loss=0.3), until_s=25.0)
    assert contacts(recorded) == []


def test_the_seed_decides_every_timeline_to_the_byte(tmp_path: Path) -> None:
    for name in ("one", "other"):
        (tmp_path / name).mkdir()
        rehearsed(shared(), tmp_path / name, seed=3, until_s=MOVES_S)
    for name in ("east", "west"):
        assert timeline(tmp_path / "one" / name) == timeline(tmp_path / "other" / name)


def test_a_fleet_out_of_sight_of_the_others_has_the_timeline_that_it_has_alone(tmp_path: Path) -> None:
    (tmp_path / "alone").mkdir()
    far = fleet("far", (WEST_M, 40.0, 0.0), (EAST_M, 40.0))
    bounds = {"x_m_min": 0.0, "y_m_min": 0.0, "x_m_max": 7.0, "y_m_max": 50.0}
    near = fleet("near", (WEST_M, LANE_M, 0.0), (EAST_M, LANE_M))
    ground = shared(near, far, bounds=bounds)
    rehearsed(ground, tmp_path)
    scenario = ground.scenarios()["near"]
    with Recorded(scenario, seed_of(1, "near"), tmp_path / "alone", NO_FAULTS, lambda _: None) as alone:
        for _ in alone.ticks():
            pass
    assert timeline(tmp_path / "near") == timeline(tmp_path / "alone")


def test_a_fleet_that_has_arrived_stands_in_the_way_of_the_others_and_is_not_touched(tmp_path: Path) -> None:
    early = fleet("early", (2.6, LANE_M, 0.0), (3.0, LANE_M), robots=1)
    late = fleet("late", (WEST_M, LANE_M, 0.0), (EAST_M, LANE_M), robots=1)
    recorded = rehearsed(shared(early, late), tmp_path)
    assert contacts(recorded) == []
    said = json.loads((tmp_path / "verdict.json").read_bytes())
    assert said["ok"], said["reason"]
    assert said["fleets"]["early"]["sim_s"] < said["fleets"]["late"]["sim_s"]


@pytest.mark.parametrize("seed", [1, *long([2])])
def test_two_leaders_that_see_the_same_do_not_give_way_to_each_other_for_ever(
    tmp_path: Path, seed: int
) -> None:
    """Mirror images without any error: without the waits that their lives draw, the time is up at 200 s."""
    east = fleet("east", (0.7, 3.0, 0.0), (5.3, 3.0), robots=1)
    north = fleet("north", (3.0, 0.7, np.pi / 2), (3.0, 5.3), robots=1)
    exact = raw()["drive"] | {"heading_error_rad": 0.0}
    bounds = {"x_m_min": 0.0, "y_m_min": 0.0, "x_m_max": 6.0, "y_m_max": 6.0}
    sensor = {"directions": 360, "range_m_max": 3.0}
    ground = shared(east, north, drive=exact, bounds=bounds, sensor=sensor, time={"time_s_max": 80.0})
    rehearsed(ground, tmp_path, seed=seed)
    said = json.loads((tmp_path / "verdict.json").read_bytes())
    assert said["ok"], said["reason"]
    assert said["between_m_min"] < 0.1  # they did meet


def test_the_verb_rehearses_all_fleets_and_says_which_one_failed(tmp_path: Path) -> None:
    (path := tmp_path / "meeting.toml").write_text(toml_text(raw()))
    said = clew("rehearse", path, "-n", "1", "--time-s-max", "1", "--out", tmp_path / "run")
    assert said.exit_code == 1
    lines = said.stdout.splitlines()
    assert lines[0].startswith("east: FAILED: ")
    assert lines[-1].startswith("FAILED: east: ")
    assert lines[-1].endswith(f"Run: {tmp_path / 'run'}")
    verdict = json.loads((tmp_path / "run" / "verdict.json").read_bytes())
    assert [each["robots"] for each in verdict["fleets"].values()] == [1, 1]
    assert clew("rehearse", path, "--deployment", "random", "--out", tmp_path / "no").exit_code == 2
    assert (
        clew(
            "rehearse", tmp_path / "run" / "scenario.toml", "--time-s-max", "1", "--out", tmp_path / "again"
        ).exit_code
        == 1
    )


# --- each premise of docs/fleets.md is needed ---------------------------------------------------------


def test_m1_fleets_that_are_faster_than_the_others_believe_touch(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(SharedGround, "speed_mps_max", property(lambda _: 0.02))

    def touches(late_m: float) -> bool:
        west = fleet("west", (EAST_M - late_m, LANE_M, np.pi), (WEST_M, LANE_M))
        (folder := tmp_path / str(late_m)).mkdir()
        return bool(contacts(rehearsed(shared(HEAD_ON[0], west), folder, until_s=6.0)))

    # The gap between them when they scan decides, in steps of 0.1 m: the first one that touches is enough.
    assert any(map(touches, (0.045, *np.arange(0.0, 0.1, 0.005))))


def test_m2_fleets_that_are_not_seen_are_touched(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(Sensor, "share_ground", lambda *_: None)
    assert contacts(rehearsed(shared(), tmp_path, until_s=MEET_S))


def test_m3_fleets_whose_bodies_drive_on_after_their_permission_touch(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def permit(self: Driver, until_s: float) -> None:
        self.drive = replace(self.drive, until_s=until_s + 2.0)

    monkeypatch.setattr(Driver, "permit", permit)
    assert contacts(rehearsed(shared(), tmp_path, until_s=MEET_S))


def test_m4_fleets_whose_hits_are_taken_for_the_own_strand_touch(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    lane = np.array([[0.0, LANE_M], [7.0, LANE_M]])

    def walls_without_lane(view: View, mission: Mission) -> Walls:
        robots = on_ground(view.points, lane, within_m=mission.hull_reach_m)
        return scan_walls(view, mission, leave_out=robots)

    monkeypatch.setattr("agents.body.watch.scan_walls", walls_without_lane)
    assert contacts(rehearsed(shared(), tmp_path, until_s=MEET_S))
