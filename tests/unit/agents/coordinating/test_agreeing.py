"""What a coordinator counts for the next formation, and how many robots that can have."""

import pytest
from msgspec.structs import replace

from agents.commands import Note
from agents.coordinating.agreeing import NO_ROOM, Agreement, Intent
from protocol.fence import Cause, Epoch
from protocol.frames import METRES_MAX, ROBOTS_MAX, Point, Pose, Vertex
from protocol.network.outbox import Outbox
from protocol.timeline import RobotStranded
from protocol.wire.codec import fits
from protocol.wire.view import (
    FORMERS_MAX,
    LEG_CORNERS_MAX,
    SEEN_BYTES_MAX,
    STRANDED_MAX,
    Counters,
    Former,
    Look,
    Report,
)
from tests.support.stages.one_step import under

MISSION = under("certified", robots=ROBOTS_MAX, goal=Point(x_m=5.0, y_m=0.0))
BEFORE, ENDED, EPOCH = (Epoch(generation=number, robot=1, life=5) for number in (1, 2, 3))
HERE = Pose(x_m=0.0, y_m=0.0, heading_rad=0.0)
THERE = Point(x_m=0.0, y_m=0.0)
DRAFTED = Former(epoch=ENDED, rank=2)


def report(robot: int, *formers: Former) -> Report:
    return Report(
        epoch=EPOCH,
        life=robot,
        number=1,
        turn=0,
        place=HERE,
        formers=formers,
        counters=Counters(in_vain=1, last_to_lead=(2,)),
        counted=ENDED,
    )


OUTSIDE = {4: replace(report(4), counted=BEFORE), 5: replace(report(5, DRAFTED), counted=BEFORE)}


@pytest.mark.parametrize(
    ("in_vain", "last", "outside", "then"),
    [
        (1, (2,), OUTSIDE, (2,)),
        (2, (2, 3), OUTSIDE, (1, 2, 3)),
        (2, (2,), OUTSIDE, (1, 3, 2)),
        (2, (), OUTSIDE, (1, 2, 3)),
        (2, (), {}, ()),
        (2, (2, 4, 5), OUTSIDE, (2, 4, 5)),
    ],
    ids=["one leader", "two leaders", "both ends", "twice round", "nobody else is there", "all others have"],
)
def test_a_robot_that_was_left_out_leads_after_two_attempts_of_the_strand_in_vain(
    in_vain: int, last: tuple[int, ...], outside: dict[int, Report], then: tuple[int, ...]
) -> None:
    """Those that have not led come first where all are listed."""
    members = {robot: report(robot, Former(epoch=ENDED, rank=robot - 1, at=THERE)) for robot in (1, 2, 3)}
    counters = Counters(in_vain=in_vain, last_to_lead=last)
    reports = {robot: replace(each, counters=counters) for robot, each in {**members, **outside}.items()}
    told = Agreement(EPOCH, Intent(Cause.PLEA, 2), MISSION, reports, set()).counters()
    assert (told.last_to_lead, told.in_vain) == (then, in_vain if then == last else 0)


@pytest.mark.parametrize(
    ("in_vain", "last", "then"),
    [
        (0, (1, 2), (1, 2)),
        (1, (1, 2, 3), (1, 2, 3)),
        (2, (1, 2, 3), (4, 1, 2, 3)),
        (2, (1, 2, 3, 5), (1, 2, 3, 5)),
        (0, (2,) * ROBOTS_MAX, (2,)),
    ],
    ids=["at first", "one after another", "both", "all others have", "told too often"],
)
def test_robots_that_are_to_lead_last_are_so_when_another_strand_is_lost(
    in_vain: int, last: tuple[int, ...], then: tuple[int, ...]
) -> None:
    counters = Counters(in_vain=in_vain, last_to_lead=last)
    strand = {robot: replace(report(robot), counters=counters) for robot in (3, 4)}
    outside = {robot: replace(report(robot), counted=BEFORE) for robot in (1, 2, 5)}
    epoch, intent = replace(EPOCH, robot=3), Intent(Cause.NEIGHBOUR_LOST, 3)
    told = Agreement(epoch, intent, MISSION, {**strand, **outside}, set()).counters()
    assert told.last_to_lead == then


def test_the_largest_report_of_the_largest_fleet_fits_where_all_but_one_are_to_lead_last() -> None:
    corner, epoch = 0.123456789, Epoch(generation=2**31, robot=ROBOTS_MAX, life=2**63)
    corners = tuple(Vertex(x_m=corner, y_m=corner, s_m=corner) for _ in range(LEG_CORNERS_MAX))
    former = Former(
        epoch=epoch, rank=9, s_m=corner, at=Point(x_m=corner, y_m=corner), leg_from_m=corner, corners=corners
    )
    ways = tuple(Point(x_m=corner, y_m=corner) for _ in range(LEG_CORNERS_MAX + 2))
    largest = replace(
        report(ROBOTS_MAX, *[former] * FORMERS_MAX),
        look=Look(number=9, way=ways),
        seen=bytes(SEEN_BYTES_MAX),
        counters=Counters(last_to_lead=tuple(range(1, ROBOTS_MAX))),
        counted=epoch,
    )
    assert fits(largest)


def test_of_the_robots_that_found_no_way_a_formation_tells_as_many_as_a_message_may() -> None:
    robots = range(1, STRANDED_MAX + 3)
    reports = {robot: report(robot) for robot in robots}
    agreement = Agreement(EPOCH, Intent(Cause.START), MISSION, reports, {*robots})
    assert agreement.drafted((1,), {}, turn=1).members[1].stranded == tuple(robots)[1 : STRANDED_MAX + 1]


def test_a_formation_has_as_many_robots_as_a_message_can_tell_and_the_others_learn_why() -> None:
    robots = range(1, ROBOTS_MAX + 1)
    places = [Pose(x_m=0.987654321 * robot, y_m=0.123 * (robot % 2), heading_rad=0.1) for robot in robots]
    reports = {
        robot: replace(report(robot), place=place, life=2**62 + robot)
        for robot, place in zip(robots, places, strict=True)
    }
    agreement = Agreement(EPOCH, Intent(Cause.START), MISSION, reports, set())
    plan = agreement.drafted(robots, {}, turn=1)
    Outbox().add(plan.as_record(), t_s=0.0, hlc="")  # else the coordinator would end here
    assert 1000 < len(plan.order) < ROBOTS_MAX
    assert plan.order == tuple(robots[: len(plan.order)])
    left_out = frozenset(robots) - set(plan.order)
    notes = agreement.stranded(plan, left_out)
    told = [
        note.record for note in notes if isinstance(note, Note) and isinstance(note.record, RobotStranded)
    ]
    assert {each.robot for each in told} == left_out
    assert {each.reason for each in told} == {NO_ROOM}


def test_a_robot_that_says_that_it_stands_where_no_path_leads_has_no_room_in_the_strand() -> None:
    """An arc length that no message can tell is refused: no member hears of the strand, nor the recorder."""
    far = Pose(x_m=METRES_MAX, y_m=METRES_MAX, heading_rad=0.0)
    reports = {
        1: report(1),
        2: replace(report(2), place=replace(HERE, x_m=-1.0)),
        3: replace(report(3), place=far),
    }
    agreement = Agreement(EPOCH, Intent(Cause.START), MISSION, reports, set())
    assert agreement.drafted((1, 2, 3), {}, turn=1).order == (1, 2)
    assert agreement.drafted((1, 2), {}, turn=1).order == (1, 2)
