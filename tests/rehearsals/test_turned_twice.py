"""A strand does not come back to where its leader began too near to something."""

import math

import pytest

from clew.rehearsal.rehearsal import Rehearsal
from protocol.fence import Cause
from protocol.frames import Pose
from protocol.timeline import ViewProposed
from tests.support.adversary import adverse
from tests.support.scenes.placed import Numbers, circle, placed, polygon
from world.bodies import arena
from world.judge.judgement import judge

RADIUS_M, EPSILON_M, MU0_M, RANGE_M = 0.3, 0.1, 0.04, 4.0
POST_RADIUS_M, POST_RAD = 0.01, math.radians(30.0)
POST_OFF_M = RADIUS_M + EPSILON_M - MU0_M + 0.0001 + POST_RADIUS_M  # a robot at the origin keeps its promise
START_OFF_M = -MU0_M - 0.001  # so far from the post a robot may start
APART_M = 0.85
OPENS_S, ENDS_S = 10.0, 25.0


def at(off_m: float) -> Numbers:
    """In the direction of the post, so far from the origin."""
    return (off_m * math.cos(POST_RAD), off_m * math.sin(POST_RAD))


def box(left_m: float, low_m: float, right_m: float, high_m: float) -> dict[str, object]:
    return polygon((left_m, low_m), (right_m, low_m), (right_m, high_m), (left_m, high_m))


def test_a_strand_does_not_turn_round_where_its_leader_began_too_near_to_something(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """A corridor with a pocket at its end: the only way leads back, until a door beside the post opens.

    A strand that turned round did so twice, since the pocket is too small, and backed up to where it began.
    There the drive's error brought its first robot 0.7 mm nearer to the post than promised.
    """
    monkeypatch.setattr(arena, "stream", adverse(lambda _low, high: high))
    door = [[0.0, -0.75], [0.1, -0.75], [0.1, 0.75], [0.0, 0.75]]
    scenario = placed(
        "turned-twice",
        [at(START_OFF_M), (-APART_M, 0.0), (-2.0 * APART_M, 0.0)],
        (4.0, -0.2),
        circle(at(POST_OFF_M), POST_RADIUS_M),
        box(-1.3, 0.45, 1.4, 2.5),
        box(-1.3, -2.5, 1.4, -1.0),
        box(-2.3, -0.045, -2.1, 2.5),
        box(-2.3, -2.5, -2.1, -0.84),
        box(-2.1, 0.6, -1.3, 2.5),
        box(-2.1, -2.5, -1.3, -1.2),
        fleet={"robot_radius_m": RADIUS_M, "separation_m": 0.1, "link_length_m_max": 2.0},
        law={"epsilon_m": EPSILON_M, "mu0_m": MU0_M},
        sensor={"directions": 1440, "range_m_max": RANGE_M},
        drive={
            "speed_mps": 0.3,
            "turn_rate_radps": 50.0,
            "heading_error_rad": MU0_M / 4.0 / RANGE_M - 2e-5,  # all but what a drive may be off
        },
        time={"time_s_max": 200.0},
        moving=[
            {
                "id": "door",
                "shape": "polygon",
                "vertices_m": door,
                "track": [[OPENS_S, 1.25, -0.275], [OPENS_S + 16.0, 1.25, 1.3]],
            }
        ],
    )
    rehearsal = Rehearsal(scenario, 1)
    # Where former drives may have left it; the loader lets no robot start there.
    rehearsal.world.bodies.resume(
        0, Pose(x_m=0.0, y_m=0.0, heading_rad=0.0), ordered=0, finished=0, now_s=0.0
    )
    for now_s in rehearsal.ticks():
        if now_s > ENDS_S:
            break
    proposed = [entry.record for _, entry in rehearsal.entries if isinstance(entry.record, ViewProposed)]
    assert [each.cause for each in proposed] == [Cause.START, Cause.NO_WAY]
    assert judge(scenario, rehearsal.entries).breaches == ()
