"""Hard starts, found by attack: obstacles that a queue hides, and places that allow no straight strand."""

import itertools
from collections.abc import Sequence

import pytest

from clew.rehearsal.rehearsal import Rehearsal
from protocol.timeline import RobotPlaced, StepPlanned
from tests.support.scenes.placed import circle, placed
from world.judge.ending import Ending
from world.judge.judgement import judge

PATIENCE_S = 60.0

Place = tuple[float, float]

FAR_AWAY = (-3.0, 3.0)
QUEUE_OF_TWO = ((1.6, 0.0), (0.0, 0.0))


def rehearsed(places: Sequence[Place], post: Place = FAR_AWAY) -> Rehearsal:
    scenario = placed(
        "start",
        places,
        (4.0, 0.0),
        circle(post, 0.05),
        fleet={"separation_m": 0.1, "link_length_m_max": 5.0},
        law={"mu0_m": 0.03},
        sensor={"directions": 720},
        drive={"turn_rate_radps": 1.5},
    )
    rehearsal = Rehearsal(scenario, 1)
    for _ in itertools.takewhile(lambda now_s: now_s < PATIENCE_S, rehearsal.ticks()):
        pass
    assert judge(rehearsal.world.scenario, rehearsal.entries).breaches == ()
    return rehearsal


def test_a_queue_on_open_ground_starts() -> None:
    assert rehearsed(QUEUE_OF_TWO).world.ending is Ending.ARRIVED


@pytest.mark.parametrize("post", [(1.2, 0.0), (0.6, 0.0), (0.8, 0.12), (0.8, -0.225)])
def test_a_robot_drives_around_a_post_on_or_beside_the_line_of_the_queue(
    post: Place,
) -> None:
    rehearsal = rehearsed(QUEUE_OF_TWO, post)
    joined = [entry.record for _, entry in rehearsal.entries if isinstance(entry.record, RobotPlaced)]
    assert [placed.rank for placed in joined] == [1]
    assert rehearsal.world.ending is Ending.ARRIVED


def test_a_post_with_enough_room_beside_the_line_of_the_queue_stops_no_robot() -> None:
    assert rehearsed(QUEUE_OF_TWO, (0.8, 0.28)).world.ending is Ending.ARRIVED


def test_the_promised_clearance_covers_a_post_behind_the_leader() -> None:
    rehearsal = rehearsed(QUEUE_OF_TWO, (1.29, 0.0))
    planned = [entry.record for _, entry in rehearsal.entries if isinstance(entry.record, StepPlanned)]
    steps = [step for step in planned if not step.joins]
    assert steps[0].promised_clearance_m == pytest.approx(0.31 - 0.05 - 0.1, abs=0.01)


@pytest.mark.parametrize(
    "places",
    [
        ((0.0, 0.0), (-0.3, 0.17), (-0.3, -0.17)),  # the second passes the third, which stands behind it
        ((0.0, 0.0), (-0.3, 0.17), (-0.3, -0.17), (-0.7, -0.17)),
    ],
)
def test_robots_whose_places_allow_no_straight_strand_join_at_other_places(
    places: Sequence[Place],
) -> None:
    rehearsal = rehearsed(places)
    assert any(isinstance(entry.record, RobotPlaced) for _, entry in rehearsal.entries)
    assert rehearsal.world.ending is Ending.ARRIVED


def test_a_bent_queue_starts() -> None:
    bent = ((0.0, 0.0), (-0.4, 0.1), (-0.7, 0.4), (-0.8, 0.8))
    assert rehearsed(bent).world.ending is Ending.ARRIVED
