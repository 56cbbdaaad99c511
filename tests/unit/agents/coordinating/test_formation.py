"""A formation: how it is made, told in pieces, and put together again by its members."""

import math

import msgspec
import pytest
from hypothesis import given
from hypothesis import strategies as st
from msgspec.structs import replace

from agents.coordinating.agreeing import Agreement, Intent
from agents.coordinating.formation import Plan, lay_path
from agents.membership.assembly import Assembly, is_path
from protocol.fence import GENERATIONS_MAX, Cause, Epoch
from protocol.frames import COUNT_MAX, ROBOTS_MAX, VERTICES_MAX, Point, Pose, Vertex
from protocol.path import Path
from protocol.wire.codec import fits
from protocol.wire.view import (
    PIECE_VERTICES_MAX,
    SEEN_BYTES_MAX,
    STRANDED_MAX,
    Counters,
    Neighbour,
    Report,
)
from tests.support.stages.one_step import under

MISSION = under("certified", robots=3, goal=Point(x_m=5.0, y_m=0.0))
EPOCH = Epoch(generation=4, robot=2, life=9)
ORDER = (1, 2, 3)


def at(x_m: float, y_m: float) -> Pose:
    return Pose(x_m=x_m, y_m=y_m, heading_rad=0.0)


def way(*places: tuple[float, float]) -> tuple[Point, ...]:
    return tuple(Point(x_m=x_m, y_m=y_m) for x_m, y_m in places)


def places(corners: int) -> dict[int, Pose]:
    return {1: at(3.0 + 0.5 * corners, 0.0), 2: at(1.0, 0.0), 3: at(0.0, 0.0)}


def plan(corners: int, *, map_of: int = 0) -> Plan:
    """A zigzag of so many corners between robots 2 and 1; robot 3 is the tail."""
    zigzag = ((2.0 + 0.5 * n, float(n % 2)) for n in range(corners))
    reports = {
        robot: Report(
            epoch=EPOCH,
            life=100 + robot,
            number=1,
            turn=0,
            place=place,
            map_number=int(robot == map_of),
            seen=b"map" if robot == map_of else None,
        )
        for robot, place in places(corners).items()
    }
    legs = {2: way((1.0, 0.0), *zigzag, (reports[1].place.x_m, 0.0))}
    return Agreement(EPOCH, Intent(Cause.START), MISSION, reports, set()).drafted(ORDER, legs, turn=3)


CORNERS = 3 * PIECE_VERTICES_MAX
LONG = plan(CORNERS)
SHORT = plan(0)


# --- making -----------------------------------------------------------------------------------------


def test_the_path_leads_through_all_places_tail_first_and_over_the_corners_of_driven_legs() -> None:
    places = {1: at(2.0, 2.0), 2: at(0.0, 0.0), 3: at(-1.0, 0.0)}
    path, places_m = lay_path(ORDER, places, {2: way((0.0, 0.0), (2.0, 0.0), (2.0, 2.0))})
    assert places_m == pytest.approx({3: 0.0, 2: 1.0, 1: 5.0})
    assert [(vertex.x_m, vertex.y_m) for vertex in path] == [(-1.0, 0.0), (2.0, 0.0), (2.0, 2.0)]


@pytest.mark.parametrize(
    ("legs", "corners", "places_m"),
    [
        # Both legs were driven: it is the path that it was.
        (
            {2: way((1.0, 0.0), (2.0, 0.0)), 3: way((0.0, 0.0), (1.0, 0.0))},
            [(0.0, 0.0), (2.0, 0.0)],
            {3: 0.0, 2: 1.0, 1: 2.0},
        ),
        # Another leg begins or ends where the driven one does.
        ({2: way((1.0, 0.0), (2.0, 0.0))}, [(0.0, 0.1), (1.0, 0.0), (2.0, 0.0)], {2: 1.005, 1: 2.005}),
        ({3: way((0.0, 0.0), (1.0, 0.0))}, [(0.0, 0.0), (1.0, 0.0), (2.0, 0.1)], {2: 1.0, 1: 2.005}),
        # Paths of two epochs: it leads from the one to the other.
        (
            {2: way((1.0, 0.2), (2.0, 0.2)), 3: way((0.0, 0.0), (1.0, 0.0))},
            [(0.0, 0.0), (1.0, 0.0), (1.0, 0.2), (2.0, 0.2)],
            {3: 0.0, 2: 1.2, 1: 2.2},
        ),
    ],
)
def test_driven_legs_are_laid_where_they_were_and_not_through_bodies_that_stand_beside_them(
    legs: dict[int, tuple[Point, ...]], corners: list[tuple[float, float]], places_m: dict[int, float]
) -> None:
    places = {1: at(2.0, 0.1), 2: at(1.0, 0.1), 3: at(0.0, 0.1)}
    path, laid_m = lay_path(ORDER, places, legs)
    assert [(vertex.x_m, vertex.y_m) for vertex in path] == corners
    assert laid_m == pytest.approx({3: 0.0} | places_m, abs=1e-3)


def test_the_largest_piece_of_the_largest_fleet_fits() -> None:
    far, life = -0.1234567890123456, 2**64 - 1
    place = Pose(x_m=far, y_m=far, heading_rad=far)
    beside = Neighbour(robot=ROBOTS_MAX, life=life, s_m=-far)
    largest = replace(
        LONG.pieces(1)[0],
        epoch=Epoch(generation=GENERATIONS_MAX, robot=ROBOTS_MAX, life=life),
        life=life,
        place=place,
        ahead=beside,
        behind=beside,
        counters=Counters(
            steps=COUNT_MAX,
            in_vain=COUNT_MAX,
            heals=COUNT_MAX,
            last_to_lead=tuple(range(1, ROBOTS_MAX + 1)),
        ),
        stranded=tuple(range(ROBOTS_MAX - STRANDED_MAX, ROBOTS_MAX)),
        map_number=COUNT_MAX,
        seen=bytes(SEEN_BYTES_MAX),
        path=(Vertex(x_m=far, y_m=far, s_m=-far),) * PIECE_VERTICES_MAX,
    )
    assert fits(largest)


@pytest.mark.parametrize("robot", ORDER)
def test_a_member_is_told_the_whole_path_and_of_robots_only_its_neighbours(robot: int) -> None:
    pieces = LONG.pieces(robot)
    assert len(pieces) == math.ceil(len(LONG.members[1].path) / PIECE_VERTICES_MAX) > 2
    assert [vertex for piece in pieces for vertex in piece.path] == [*LONG.members[1].path]
    first = pieces[0]
    assert (first.rank, first.members, first.life, first.place) == (
        robot - 1,
        3,
        100 + robot,
        places(CORNERS)[robot],
    )
    beside = {each.robot: (each.life, each.s_m) for each in (first.ahead, first.behind) if each is not None}
    neighbours = {other for other in ORDER if abs(other - robot) == 1}
    assert beside == {other: (100 + other, LONG.members[other].s_m) for other in neighbours}


def test_a_formation_is_told_again_byte_for_byte() -> None:
    told = [[msgspec.msgpack.encode(piece) for piece in LONG.pieces(2)] for _ in range(2)]
    assert told[0] == told[1]


def test_only_the_leader_is_told_the_map_and_only_once() -> None:
    told = [[piece.seen for piece in plan(CORNERS, map_of=3).pieces(robot)] for robot in ORDER]
    assert len(told[0]) > 2
    assert [seen.count(b"map") for seen in told] == [1, 0, 0]


def test_the_record_tells_what_all_members_are_told() -> None:
    record = LONG.as_record()
    assert (record.epoch, record.turn, record.order) == (EPOCH.number, 3, ORDER)
    assert record.places_m == tuple(LONG.members[robot].s_m for robot in ORDER)
    assert record.lives == ("65", "66", "67")
    assert record.driven == (False, True, False)
    assert [(point.x_m, point.y_m) for point in record.laid] == [(v.x_m, v.y_m) for v in LONG.members[1].path]


# --- putting together -------------------------------------------------------------------------------


@given(st.data())
def test_pieces_in_any_order_lost_and_repeated_make_the_formation_when_all_are_there(
    data: st.DataObject,
) -> None:
    pieces = LONG.pieces(2)
    arrived = data.draw(st.lists(st.sampled_from(range(len(pieces))), max_size=12))
    assembly = Assembly()
    for count, index in enumerate(arrived, start=1):
        assembly.add(pieces[index])
        assert (assembly.whole is not None) == (set(arrived[:count]) == set(range(len(pieces))))
    if assembly.whole is not None:
        formation, path = assembly.whole
        assert formation == pieces[0]
        assert list(path) == [*LONG.members[1].path]


def test_arc_lengths_are_used_as_they_are_told_and_not_computed_again() -> None:
    (piece,) = SHORT.pieces(2)
    off_m = 1e-9  # rounding at the coordinator
    told = tuple(Vertex(x_m=v.x_m, y_m=v.y_m, s_m=v.s_m + (off_m if v.s_m else 0.0)) for v in piece.path)
    assembly = Assembly()
    assembly.add(replace(piece, path=told))
    assert assembly.whole is not None
    assert [vertex.s_m for vertex in assembly.whole[1]] == [vertex.s_m for vertex in told]


def test_vertices_whose_arc_lengths_cannot_be_are_no_path() -> None:
    (piece,) = SHORT.pieces(2)
    assembly = Assembly()
    assembly.add(replace(piece, path=tuple(replace(vertex, s_m=2.0 * vertex.s_m) for vertex in piece.path)))
    assert assembly.whole is None
    assert is_path(list(Path([Point(x_m=0.0, y_m=0.0), Point(x_m=3.0, y_m=4.0)])))


def test_nothing_is_whole_before_anything_has_come() -> None:
    assembly = Assembly()
    assert assembly.whole is None
    assembly.add(LONG.pieces(2)[1])
    assert assembly.whole is None, "the first piece is missing"


def test_a_coordinator_that_lies_fills_no_more_memory_than_the_longest_path() -> None:
    assembly = Assembly()
    (piece,) = SHORT.pieces(2)
    for first in range(0, 2 * VERTICES_MAX, PIECE_VERTICES_MAX // 2):
        assembly.add(replace(piece, first=first))
    assert len(assembly._pieces) <= 1 + VERTICES_MAX // PIECE_VERTICES_MAX
