import math

import numpy as np
import pytest
import shapely
from hypothesis import given
from hypothesis import strategies as st

from protocol.frames import Point, Vertex
from protocol.path import Path, straightened
from tests.support.strategies.path_strategies import paths

ROUNDING_M = 1e-9  # of sums over at most 12 vertices within 5 m
shares = st.floats(0.0, 1.0)
orders = st.randoms(use_true_random=False)


def line_of(path: Path) -> shapely.LineString:
    return shapely.LineString([(vertex.x_m, vertex.y_m) for vertex in path.told_from(0, len(path))])


@given(paths())
def test_arc_length_equals_shapelys_length(path: Path) -> None:
    assert path[0].s_m == 0.0
    assert path.end_m == pytest.approx(line_of(path).length, abs=ROUNDING_M)


@given(paths(), shares)
def test_the_place_at_an_arc_length_equals_shapelys_interpolation(path: Path, share: float) -> None:
    at = path.at(share * path.end_m)
    expected = line_of(path).interpolate(share * path.end_m)
    assert (at.x_m, at.y_m) == pytest.approx((expected.x, expected.y), abs=ROUNDING_M)


@given(paths())
def test_the_place_at_a_vertexs_arc_length_is_the_vertex(path: Path) -> None:
    for vertex in path.told_from(0, len(path)):
        at = path.at(vertex.s_m)
        assert (at.x_m, at.y_m) == pytest.approx((vertex.x_m, vertex.y_m), abs=ROUNDING_M)


@given(paths(), st.floats(0.0, 10.0))
def test_places_beyond_the_ends_are_the_ends(path: Path, beyond_m: float) -> None:
    assert path.at(-beyond_m) == path.at(0.0)
    assert path.at(path.end_m + beyond_m) == path.at(path.end_m)


@given(paths(), shares, shares, shares)
def test_arc_length_is_additive(path: Path, one: float, two: float, three: float) -> None:
    low_m, middle_m, high_m = (share * path.end_m for share in sorted((one, two, three)))
    parts = [path.between(low_m, middle_m), path.between(middle_m, high_m), path.between(low_m, high_m)]
    lengths_m = [shapely.LineString(part).length for part in parts]
    assert lengths_m[0] + lengths_m[1] == pytest.approx(lengths_m[2], abs=ROUNDING_M)
    assert lengths_m[2] == pytest.approx(high_m - low_m, abs=ROUNDING_M)


@given(paths(), shares, shares, shares)
def test_a_part_has_the_shape_of_the_whole(path: Path, one: float, two: float, within: float) -> None:
    low_m, high_m = sorted((one * path.end_m, two * path.end_m))
    part = shapely.LineString(path.between(low_m, high_m))
    at = path.at(low_m + within * (high_m - low_m))
    expected = part.interpolate(within * (high_m - low_m))
    assert (at.x_m, at.y_m) == pytest.approx((expected.x, expected.y), abs=ROUNDING_M)


@given(paths(), shares)
def test_a_part_that_ends_before_it_begins_is_its_first_place(path: Path, share: float) -> None:
    begin_m = share * path.end_m
    corners = path.between(begin_m, begin_m - 1.0)
    assert len(corners) == 2
    assert np.array_equal(corners[0], corners[1])


@given(paths(), shares)
def test_the_next_vertex_is_the_first_that_is_still_ahead(path: Path, share: float) -> None:
    s_m = share * path.end_m
    index = path.next_vertex(s_m)
    assert all(vertex.s_m <= s_m for vertex in path.told_from(0, index))
    assert all(vertex.s_m > s_m for vertex in path.told_from(index, len(path)))


@given(paths())
def test_beyond_the_end_there_is_no_next_vertex(path: Path) -> None:
    assert path.next_vertex(path.end_m) == len(path)


@given(paths(), st.integers(1, 12), st.data())
def test_the_whole_path_is_learnt_in_any_order_and_repetition_of_messages(
    path: Path, known: int, data: st.DataObject
) -> None:
    known = min(known, len(path))
    share = st.tuples(st.integers(0, len(path)), st.integers(1, len(path)))
    messages = [(first, path.told_from(first, most)) for first, most in data.draw(st.lists(share))]
    learner = _knowing(path, known)
    for first, vertices in messages:
        before = len(learner)
        learner.learn(first, vertices)
        assert len(learner) >= before
        assert path.told_from(0, len(learner)) == learner.told_from(0, len(learner))
    learner.learn(len(learner), path.told_from(len(learner), len(path)))
    assert learner.told_from(0, len(path)) == path.told_from(0, len(path))


@given(paths(), st.data())
def test_known_vertices_are_not_added_again(path: Path, data: st.DataObject) -> None:
    first = data.draw(st.integers(0, len(path)))
    learner = _knowing(path, first)
    for _ in range(2):
        learner.learn(first, path.told_from(first, len(path)))
    assert learner.told_from(0, 2 * len(path)) == path.told_from(0, len(path))


@given(paths(), st.integers(1, 12), st.data())
def test_all_parts_of_one_path_fit_what_is_known_of_it(path: Path, known: int, data: st.DataObject) -> None:
    learner = _knowing(path, min(known, len(path)))
    first = data.draw(st.integers(0, len(path)))
    assert learner.fits(first, path.told_from(first, len(path)))


@pytest.mark.parametrize(
    ("first", "told", "fits"),
    [
        (1, [(1.5, 0.0, 1.5)], True),  # the last segment has become longer
        (1, [(1.5, 0.0, 1.4)], False),
        (1, [(0.5, 0.0, 0.5)], False),
        (1, [(1.0, 0.5, 1.5)], False),  # the end of the known path is not on it any more
        (0, [(0.5, 0.0, 0.0)], False),
        (2, [(1.0, 1.0, 2.0)], True),
        (2, [(1.0, 1.0, 2.1)], False),
        (2, [(1.0, 1.0, 2.0), (2.0, 1.0, 3.0)], True),
        (2, [(1.0, 1.0, 2.0), (2.0, 1.0, 2.0)], False),
        (3, [(9.0, 9.0, 0.0)], True),  # it is beyond a gap
    ],
)
def test_vertices_fit_only_if_they_continue_the_known_path(
    first: int, told: list[tuple[float, float, float]], *, fits: bool
) -> None:
    known = Path([Point(x_m=0.0, y_m=0.0), Point(x_m=1.0, y_m=0.0)])
    vertices = [Vertex(x_m=x_m, y_m=y_m, s_m=s_m) for x_m, y_m, s_m in told]
    assert known.fits(first, vertices) is fits
    assert known.told_from(0, 9) == Path([Point(x_m=0.0, y_m=0.0), Point(x_m=1.0, y_m=0.0)]).told_from(0, 9)


def test_vertices_beyond_a_gap_are_ignored_until_they_are_sent_again() -> None:
    path = Path([Point(x_m=float(x), y_m=0.0) for x in range(4)])
    learner = _knowing(path, 1)
    learner.learn(2, path.told_from(2, 2))
    assert len(learner) == 1


def test_known_vertices_never_change() -> None:
    learner = Path([Point(x_m=0.0, y_m=0.0), Point(x_m=1.0, y_m=0.0)])
    learner.learn(0, [Vertex(x_m=float(x), y_m=9.0, s_m=float(x)) for x in range(3)])
    assert [vertex.y_m for vertex in learner.told_from(0, 3)] == [0.0, 0.0, 9.0]


def test_at_most_the_requested_number_of_vertices_is_sent() -> None:
    path = Path([Point(x_m=float(x), y_m=0.0) for x in range(5)])
    assert [vertex.x_m for vertex in path.told_from(1, 2)] == [1.0, 2.0]
    assert path.told_from(5, 2) == ()
    assert path.told_from(2**53, 2) == ()  # the highest count in messages


@given(paths())
def test_a_straightened_path_has_the_same_places_at_the_same_arc_lengths(path: Path) -> None:
    straight = Path(straightened([Point(x_m=vertex.x_m, y_m=vertex.y_m) for vertex in path]))
    assert straight.end_m == pytest.approx(path.end_m, abs=ROUNDING_M)
    for vertex in path:
        at = straight.at(vertex.s_m)
        assert (at.x_m, at.y_m) == pytest.approx((vertex.x_m, vertex.y_m), abs=10.0 * ROUNDING_M)


def test_a_straightened_path_has_only_corners_and_ends() -> None:
    places = [(0.0, 0.0), (1.0, 0.0), (2.0, 0.0), (2.0, 1.0), (2.0, 2.5), (2.0, 1.5)]
    corners = straightened([Point(x_m=x_m, y_m=y_m) for x_m, y_m in places])
    assert [(corner.x_m, corner.y_m) for corner in corners] == [
        (0.0, 0.0),
        (2.0, 0.0),
        (2.0, 2.5),
        (2.0, 1.5),
    ]


def test_a_new_vertex_knows_its_arc_length() -> None:
    path = Path([Point(x_m=0.0, y_m=0.0)])
    assert path.extend(Point(x_m=3.0, y_m=4.0)).s_m == 5.0
    assert path.extend(Point(x_m=3.0, y_m=4.0)).s_m == 5.0
    assert path.extend(Point(x_m=4.0, y_m=5.0)).s_m == pytest.approx(5.0 + math.sqrt(2.0))


def test_a_path_of_one_vertex_is_that_place() -> None:
    path = Path([Point(x_m=1.0, y_m=2.0)])
    assert path.at(7.0) == Point(x_m=1.0, y_m=2.0)
    assert path.between(0.0, 7.0).tolist() == [[1.0, 2.0], [1.0, 2.0]]


def _knowing(path: Path, vertices: int) -> Path:
    return Path(Point(x_m=vertex.x_m, y_m=vertex.y_m) for vertex in path.told_from(0, vertices))
