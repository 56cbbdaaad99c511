"""M4 of docs/fleets.md: no hit is left out of a permission. A random search of straight drives found this."""

import math
from collections.abc import Sequence
from dataclasses import dataclass

from msgspec.structs import replace

from agents.events import LinkHeard
from protocol.frames import Point, Pose
from protocol.path import Path
from tests.support.stages.member_stage import MemberStage
from tests.support.stages.one_step import under
from tests.support.stages.strand_stage import life_of
from world.geometry.shapes import Circle

Place = tuple[float, float]

SPEED_MPS = 0.5
MISSION = under(
    "certified",
    robots=2,
    robot_radius_m=0.1,
    speed_mps=SPEED_MPS,
    obstacle_speed_mps_max=SPEED_MPS,
    directions=360,
)
AHEAD, FOLLOWS = 1, 2


@dataclass(frozen=True)
class Scanned:
    """A follower's last scan before the contact: where the four robots were then."""

    before_s: float
    here: Place
    ahead: Place
    """Its neighbour, which hides the others."""
    others: Sequence[Place]
    touches_at: Place


A = Scanned(1.17, (-0.585, 0.0), (-0.144, 0.208), [(0.383, 0.426), (0.106, 0.291)], (0.0, 0.0))
B = Scanned(0.92, (0.484, 0.385), (0.048, 0.233), [(-0.461, 0.0), (-0.210, 0.180)], (0.199, 0.023))


def permitted_s(scanned: Scanned) -> float:
    """For how long after the scan a follower may drive on, straight to a corner behind the contact."""
    x_m, y_m = scanned.here
    off_x, off_y = scanned.touches_at[0] - x_m, scanned.touches_at[1] - y_m
    length_m = math.hypot(off_x, off_y)
    corner_m = SPEED_MPS * scanned.before_s + 0.05
    corner = (x_m + off_x * corner_m / length_m, y_m + off_y * corner_m / length_m)
    bodies = {AHEAD: scanned.ahead, FOLLOWS: scanned.here}
    places = {robot: Pose(x_m=at[0], y_m=at[1], heading_rad=0.0) for robot, at in bodies.items()}
    hulls = [Circle(centre_m=at, radius_m=MISSION.robot_radius_m) for at in scanned.others]
    stage = MemberStage(MISSION, places, (AHEAD, FOLLOWS), shapes=hulls, is_checked=False)
    path = Path([Point(x_m=x, y_m=y) for x, y in (scanned.here, corner, scanned.ahead)])
    stage.form(path, {FOLLOWS: 0.0, AHEAD: path.end_m}, driven=True)
    stage.now_s = 0.1
    stage.wake(FOLLOWS)
    stage.wake(AHEAD)
    told = replace(stage.newest_ahead(AHEAD), authority_m=corner_m, life=life_of(AHEAD))
    stage.give(FOLLOWS, LinkHeard(AHEAD, 100, told))
    stage.now_s = 0.2
    stage.wake(FOLLOWS)
    drive = stage.parts[FOLLOWS].driver.drive
    assert drive.target is not None
    assert math.dist((drive.target.x_m, drive.target.y_m), corner) < 1e-9
    assert drive.until_s is not None
    return drive.until_s - stage.now_s


def test_a_robot_that_comes_out_from_behind_a_neighbour_is_not_touched() -> None:
    assert 0.0 < permitted_s(A) < A.before_s
    assert 0.0 < permitted_s(B) < B.before_s
