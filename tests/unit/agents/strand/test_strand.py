"""Places in the strand as conversations: what a robot sends, what it believes, and when a link is silent."""

import math

import numpy as np
import pytest
import shapely

from agents.commands import Note, Tell
from agents.events import LinkHeard
from agents.strand.grants import GRANT_M_MIN, ONWARD_M
from agents.strand.leader import Leader
from agents.strand.news import NEWS_S, URGENT_S
from agents.strand.strand import Strand
from protocol.fence import Epoch
from protocol.frames import Point, Pose, Vertex
from protocol.timeline import LinkHeard as LinkHeardAgain
from protocol.timeline import LinkSilent, MessageRefused, StepPlanned
from protocol.wire.messages import AheadState, BehindState
from protocol.wire.view import Counters
from tests.support.stages.one_step import plan, under
from tests.support.stages.strand_stage import (
    KEEP_M,
    KNOWN,
    MISSION,
    ORDER,
    PLACES,
    SILENCE_S,
    ahead,
    behind,
    formation,
    granted,
    leading,
    own,
    place,
    queue_path,
    told_ahead,
    told_behind,
)


def test_all_robots_measure_the_path_of_the_formation() -> None:
    strands = {robot: place(robot) for robot in ORDER}
    assert [strands[robot].start_m for robot in (1, 2, 3)] == [0.0, 1.0, 2.0]
    assert {strand.path.told_from(0, 9) for strand in strands.values()} == {strands[1].path.told_from(0, 9)}


def test_each_robot_has_links_to_its_two_neighbours() -> None:
    links = [[link.neighbour for link in place(robot).links] for robot in ORDER]
    assert links == [[2], [3, 1], [2]]


def test_a_robot_alone_has_no_link_and_sends_no_state() -> None:
    alone = place(1, (1,))
    assert alone.watch(99.0) == []
    assert alone.tell(own(0.0), 0.0) == []
    assert (alone.grants.tail_m, alone.grants.stretch_m) == (0.0, 0.0)


def test_a_leg_that_counts_as_driven_has_been_driven_up_to_the_robots_own_place() -> None:
    path = queue_path(ORDER, PLACES)
    told = formation(2, ORDER, PLACES, {3: 2.0, 2: 1.0, 1: 0.0}, path, driven=True)
    assert (Strand(2, told, path, MISSION, 0.0).own_leg_m, place(2).own_leg_m) == (1.0, 2.0)


# --- grants -----------------------------------------------------------------------------------------


def test_a_robot_grants_the_path_behind_it_minus_the_distance_to_keep() -> None:
    strand = place(3)
    commands = strand.tell(own(2.0), 0.0)
    assert strand.grants.keep_m == pytest.approx(KEEP_M)
    assert granted(commands) == pytest.approx([2.0 - KEEP_M])
    assert told_behind(commands, 2).authority_m == granted(commands)[0]


def test_a_grant_grows_with_progress_in_steps_that_matter() -> None:
    strand = leading()
    steps_m = [2.0, 2.0 + 0.9 * GRANT_M_MIN, 2.0 + 1.1 * GRANT_M_MIN, 2.0 + 1.2 * GRANT_M_MIN]
    grants = [granted(strand.tell(own(progress_m), 0.0)) for progress_m in steps_m]
    assert grants == [[pytest.approx(2.0 - KEEP_M)], [], [pytest.approx(steps_m[2] - KEEP_M)], []]


def test_a_robot_that_has_arrived_grants_the_last_millimetre() -> None:
    strand = leading()
    strand.tell(own(2.0), 0.0)
    assert granted(strand.tell(own(2.001, arrived=True), 0.0)) == pytest.approx([2.001 - KEEP_M])


def test_a_path_that_turns_back_does_not_reduce_a_grant() -> None:
    strand = place(3)
    first = granted(strand.tell(own(2.0), 0.0))
    for corner in (Point(x_m=3.0, y_m=0.2), Point(x_m=1.0, y_m=0.2)):
        strand.path.extend(corner)
    assert granted(strand.tell(own(2.0), 1.0)) == []
    assert told_behind(strand.tell(own(2.0), 2.0), 2).authority_m == first[0]


def test_a_leader_does_not_grant_ground_beside_the_way_that_it_is_likely_to_go_on() -> None:
    stands_m, aside_m = 2.25, 0.25
    ways = {"onward": ((3.0, 0.4), (3.0, 0.8)), "back": ((3.0, aside_m), (2.7, aside_m))}
    grants = dict[str, list[float]]()
    for name, way in ways.items():
        strand = place(3)
        strand.growth.begin(Point(x_m=3.0, y_m=aside_m), way)
        grants[name] = granted(strand.tell(own(stands_m), 0.0))
        grants[f"{name}, arrived"] = granted(strand.tell(own(stands_m, arrived=True), 0.0))
    near_m, less_m = math.sqrt(KEEP_M**2 - aside_m**2), math.sqrt((KEEP_M + ONWARD_M) ** 2 - aside_m**2)
    assert grants == {
        "onward": [pytest.approx(2.0 - near_m)],
        "onward, arrived": [],
        "back": [pytest.approx(1.7 - less_m)],
        "back, arrived": [pytest.approx(2.0 - near_m)],
    }


def test_a_leader_keeps_off_the_place_of_a_robot_that_has_no_grant_yet() -> None:
    # A robot of radius 0 is invisible to scans, and 0.33 m behind is too little for a grant.
    pair = under("certified", robots=2, separation_m=0.3, goal=Point(x_m=-2.0, y_m=0.0), directions=360)
    places = {robot: Pose(x_m=0.33 * robot, y_m=0.0, heading_rad=0.0) for robot in (1, 2)}
    path = queue_path((2, 1), places)
    told = formation(2, (2, 1), places, {2: 0.33, 1: 0.0}, path)
    strand = Strand(2, told, path, pair, 0.0)
    strand.tell(own(strand.start_m), 0.0)
    ground = strand.grants.ground
    planned = plan(Leader(pair, places[2]), [], pair, ground, at=places[2])
    assert isinstance(planned, StepPlanned)
    step = shapely.LineString([(planned.x_m, planned.y_m), (planned.target.x_m, planned.target.y_m)])
    assert step.distance(shapely.Point(places[1].x_m, 0.0)) >= strand.grants.keep_m - 1e-9


def test_a_robot_without_a_robot_behind_keeps_off_no_ground() -> None:
    assert place(1, (1,)).grants.keep_m == 0.0


def test_the_tail_grants_nothing() -> None:
    strand = place(1)
    assert granted(strand.tell(own(0.0), 0.0)) == []


def test_the_stretch_is_the_part_of_the_grant_that_the_robot_behind_has_not_driven() -> None:
    strand = place(3)
    strand.tell(own(2.0), 0.0)
    stretch_m = [strand.grants.stretch_m]
    strand.hear(LinkHeard(2, 1, behind(progress_m=1.2)), 0.0)
    stretch_m.append(strand.grants.stretch_m)
    strand.hear(LinkHeard(2, 2, behind(progress_m=2.0 - KEEP_M)), 0.0)
    stretch_m.append(strand.grants.stretch_m)
    assert stretch_m == pytest.approx([1.0 - KEEP_M, 0.8 - KEEP_M, 0.0]), "at first it counts from its place"


# --- telling ----------------------------------------------------------------------------------------


def told_to(strand: Strand, now_s: float) -> list[int]:
    return sorted(command.robot for command in strand.tell(own(1.0), now_s) if isinstance(command, Tell))


def heard_both(strand: Strand, number: int, now_s: float) -> None:
    strand.hear(LinkHeard(3, number, ahead(t_s=now_s)), now_s)
    strand.hear(LinkHeard(1, number, behind(1, t_s=now_s)), now_s)


def test_news_is_sent_again_for_a_while_and_then_on_every_heartbeat() -> None:
    strand, told = place(2), []
    for tenth in range(21):
        heard_both(strand, 1 + tenth, tenth / 10.0)
        told += [tenth] if told_to(strand, tenth / 10.0) else []
    repeated = round(NEWS_S / URGENT_S)
    assert told[: repeated + 1] == [*range(repeated), 7]
    assert told[repeated + 1 :] == [10, 13, 16, 19]


def test_a_robot_sends_more_often_while_a_neighbour_is_not_heard() -> None:
    strand = place(2)
    heard_both(strand, 1, 0.0)
    told = [bool(told_to(strand, tenth / 10.0)) for tenth in range(21)]
    assert all(told[8:]), "at 2.5 heartbeats, something is wrong with one direction of a link"


def test_a_strand_is_quiet_for_as_long_as_all_robots_behind_said_that_they_stand() -> None:
    strand, middle, quiet_s = place(3), place(2), []
    assert strand.quiet_s == 0.0, "nobody was heard"
    for number, (now_s, tail_stands, stands) in enumerate(
        [(1.0, False, True), (2.0, True, True), (3.0, True, True), (4.0, True, False)], start=1
    ):
        middle.hear(LinkHeard(1, number, behind(1, stand=tail_stands, t_s=now_s)), now_s)
        state = told_ahead(middle.tell(own(1.0, stands=stands), now_s), 3)
        strand.hear(LinkHeard(2, number, state), now_s)
        quiet_s.append(strand.quiet_s)
    assert quiet_s == [0.0, 1.0, 2.0, 0.0]


@pytest.mark.parametrize("news", ["grant", "vertex", "arrival"])
def test_news_is_sent_at_once(news: str) -> None:
    strand, after = leading(), own(2.0)
    strand.tell(own(2.0), 0.0)
    if news == "grant":
        after = own(2.5)
    elif news == "vertex":
        strand.path.extend(Point(x_m=8.0, y_m=0.0))
    elif news == "arrival":
        after = own(2.0, arrived=True)
    assert told_behind(strand.tell(after, 0.01), 2).arrived == (news == "arrival")


def test_the_path_is_sent_from_the_acknowledged_vertex_on_until_it_is_acknowledged() -> None:
    strand = place(3)
    last = strand.path[KNOWN - 1]  # is sent again, since it may have moved
    assert told_behind(strand.tell(own(2.0), 0.0), 2).path == (last,)
    corner = strand.path.extend(Point(x_m=4.0, y_m=0.0))
    for now_s in (1.0, 2.0):
        state = told_behind(strand.tell(own(2.0), now_s), 2)
        assert (state.path_from, state.path) == (KNOWN - 1, (last, corner))
    strand.hear(LinkHeard(2, 1, behind(vertices=KNOWN + 1)), 2.5)
    state = told_behind(strand.tell(own(2.0), 3.0), 2)
    assert (state.path_from, state.path) == (KNOWN, (corner,))


def test_vertices_from_ahead_are_acknowledged_and_passed_on_behind() -> None:
    strand = place(2)
    corner = Vertex(x_m=4.0, y_m=0.0, s_m=3.0)
    strand.hear(LinkHeard(3, 1, ahead(path=(corner,), authority_m=1.5)), 0.1)
    commands = strand.tell(own(1.0), 0.2)
    assert told_ahead(commands, 3).vertices == KNOWN + 1
    assert told_behind(commands, 1).path[-1] == corner


def test_the_tails_progress_is_passed_on_to_the_robots_ahead() -> None:
    strand = place(2)
    before = told_ahead(strand.tell(own(1.0), 0.0), 3).tail_progress_m
    strand.tell(own(1.0), 0.4)
    strand.hear(LinkHeard(1, 1, behind(1, progress_m=0.4, tail_m=0.4)), 0.5)
    assert (before, told_ahead(strand.tell(own(1.0), 1.0), 3).tail_progress_m) == (0.0, 0.4)


def test_the_tail_sends_its_own_progress_as_the_tails() -> None:
    assert told_ahead(place(1).tell(own(0.6), 0.0), 2).tail_progress_m == 0.6


# --- authority --------------------------------------------------------------------------------------


def test_without_a_grant_a_robot_may_be_where_it_stands() -> None:
    assert [place(robot).authority_m for robot in (1, 2)] == [0.0, 1.0]
    assert [place(robot).grants.granted_m for robot in (2, 3)] == [0.0, 1.0]


def test_authority_only_grows_for_any_order_of_messages() -> None:
    strand = place(2)
    seen = []
    for number, authority_m in ((3, 1.4), (1, 1.2), (4, 1.6), (2, 1.3), (5, 1.5)):
        strand.hear(LinkHeard(3, number, ahead(authority_m=authority_m)), 0.1)
        seen.append(strand.authority_m)
    assert seen == [1.4, 1.4, 1.6, 1.6, 1.6]


OTHER_EPOCHS = [
    Epoch(generation=2, robot=3, life=1003),
    Epoch(generation=1, robot=2, life=1003),
    Epoch(generation=1, robot=3, life=1004),
]
CORNER = Vertex(x_m=4.0, y_m=0.0, s_m=3.0)


@pytest.mark.parametrize(
    ("robot", "state"),
    [
        *((3, ahead(epoch=epoch, authority_m=1.9, path=(CORNER,))) for epoch in OTHER_EPOCHS),
        *((1, behind(1, epoch=epoch, progress_m=0.0, handed=7)) for epoch in OTHER_EPOCHS),
        (7, ahead(authority_m=1.9)),
        (1, ahead(authority_m=1.9)),
        (3, ahead(life=9, authority_m=1.9, path=(CORNER,))),
        (1, behind(1, life=9, handed=7)),
        (7, behind(1, handed=7)),
    ],
)
def test_states_of_another_epoch_or_life_or_of_a_stranger_are_void(
    robot: int, state: AheadState | BehindState
) -> None:
    """V2 of the schedules: the second life of the robot ahead plans other ground than the first."""
    strand = place(2)
    assert strand.hear(LinkHeard(robot, 1, state), 0.1) == []
    assert (strand.authority_m, strand.grants.tail_m, len(strand.path)) == (1.0, 0.0, KNOWN)
    assert [link.state for link in strand.links] == [None, None]


@pytest.mark.parametrize(
    ("robot", "state", "why"),
    [
        (3, behind(3, progress_m=1.0), "other side"),
        (1, ahead(life=1001), "other side"),
        (3, ahead(progress_m=1.8, authority_m=1.9), "stands at 1.8"),
        (3, ahead(path=(CORNER,), progress_m=9.0, authority_m=3.1), "of a path of 3.0"),
        (3, ahead(path=(Vertex(x_m=4.0, y_m=0.0, s_m=4.0),)), "does not continue"),
        (3, ahead(path_from=0, path=(Vertex(x_m=1.0, y_m=0.1, s_m=0.0),)), "does not continue"),
        (1, behind(1, progress_m=0.1), "may be at 0.000 to 0.000"),
        (1, behind(1, tail_m=0.1), "tail"),
        (1, behind(1, vertices=KNOWN + 1), "vertices"),
    ],
)
def test_a_state_that_cannot_be_true_is_refused_and_nothing_is_taken_from_it(
    robot: int, state: AheadState | BehindState, why: str
) -> None:
    strand = place(2)
    (command,) = strand.hear(LinkHeard(robot, 1, state), 0.1)
    assert isinstance(command, Note)
    assert isinstance(command.record, MessageRefused)
    assert command.record.key == f"link/r{robot}/r2"
    assert why in command.record.reason
    assert (strand.authority_m, strand.grants.tail_m, len(strand.path)) == (1.0, 0.0, KNOWN)
    assert [link.state for link in strand.links] == [None, None]


def test_the_last_vertex_of_the_path_ahead_may_move_straight_on_and_no_other_way() -> None:
    strand, refused = place(2), []
    for number, last in enumerate(
        [CORNER, Vertex(x_m=4.5, y_m=0.0, s_m=3.5), Vertex(x_m=4.5, y_m=0.5, s_m=4.0)], start=1
    ):
        refused.append(bool(strand.hear(LinkHeard(3, number, ahead(path=(last,))), 0.1)))
    assert refused == [False, False, True]
    assert strand.path.end_m == 3.5


# --- silence ----------------------------------------------------------------------------------------


def test_a_silence_and_its_end_are_each_recorded_once() -> None:
    strand = place(3)
    strand.hear(LinkHeard(2, 1, behind()), 0.0)
    assert strand.watch(SILENCE_S) == []
    (noted,) = strand.watch(SILENCE_S + 0.5)
    assert noted == Note(LinkSilent(neighbour=2, silent_s=SILENCE_S + 0.5))
    assert strand.watch(9.0) == []
    strand.hear(LinkHeard(2, 2, behind(t_s=9.9)), 10.0)
    assert strand.watch(10.0) == [Note(LinkHeardAgain(neighbour=2))]
    assert strand.watch(9.9 + SILENCE_S) == []
    assert len(strand.watch(10.0 + SILENCE_S)) == 1


def test_each_link_falls_silent_independently() -> None:
    strand = place(2)
    strand.hear(LinkHeard(3, 1, ahead(authority_m=1.0)), 0.0)
    strand.hear(LinkHeard(1, 1, behind(1, t_s=0.75)), 0.75)
    assert strand.watch(1.5) == [Note(LinkSilent(neighbour=3, silent_s=1.5))]
    assert strand.watch(2.0) == [Note(LinkSilent(neighbour=1, silent_s=1.25))]


@pytest.mark.parametrize(("number", "t_s"), [(1, 4.9), (2, 4.9), (3, 5.0 - SILENCE_S - 0.1)])
def test_an_old_or_late_state_does_not_end_a_silence(number: int, t_s: float) -> None:
    strand = place(3)
    strand.hear(LinkHeard(2, 2, behind()), 0.0)
    strand.watch(5.0)
    strand.hear(LinkHeard(2, number, behind(t_s=t_s)), 5.0)
    assert strand.watch(5.0) == []
    assert [link.silent for link in strand.links] == [True]


# --- counters and the way back ----------------------------------------------------------------------


def test_counts_since_the_strand_advanced_begin_anew_when_the_path_has_grown_towards_the_goal() -> None:
    path = queue_path(ORDER, PLACES)
    counters = Counters(steps=4, in_vain=2, last_to_lead=(1, 2))
    told = formation(2, ORDER, PLACES, {3: 2.0, 2: 1.0, 1: 0.0}, path, back_by_m=1.0, counters=counters)
    strand, counted = Strand(2, told, path, MISSION, 0.0), []
    for number, (vertices, backs_up) in enumerate([((), True), ((CORNER,), True), ((), False)], start=1):
        strand.hear(LinkHeard(3, number, ahead(path=vertices, backs_up=backs_up)), 0.1)
        counted.append(strand.counters.in_vain)
    assert counted == [2, 2, 0], "a step that only makes room does not count"
    assert strand.counters == Counters(steps=4)


@pytest.mark.parametrize(("steps", "in_vain"), [([0.9], 2), ([1.1], 0), ([0.9, -0.9, 0.9], 2)])
def test_a_strand_has_advanced_when_its_leader_stands_further_off_than_robots_keep(
    steps: list[float], in_vain: int
) -> None:
    """Locked in, leaders still creep, or go to and fro; if that were hope, no other robot would lead."""
    path, ways_m = queue_path(ORDER, PLACES), MISSION.robot_keep_m * np.array(steps)
    told = formation(2, ORDER, PLACES, {3: 2.0, 2: 1.0, 1: 0.0}, path, counters=Counters(in_vain=2))
    strand = Strand(2, told, path, MISSION, 0.0)
    along = np.stack([3.0 + np.cumsum(ways_m), 2.0 + np.cumsum(np.abs(ways_m))], axis=-1).tolist()
    corners = tuple(Vertex(x_m=x_m, y_m=0.0, s_m=s_m) for x_m, s_m in along)
    strand.hear(LinkHeard(3, 1, ahead(path=corners)), 0.1)
    assert strand.path.end_m == pytest.approx(corners[-1].s_m)
    assert strand.counters.in_vain == in_vain


def test_the_tail_hears_through_all_robots_that_the_first_one_leads_for_good() -> None:
    middle, tail = place(2, back_by_m=1.0), place(1, back_by_m=1.0)
    passed = []
    for number, backs_up in ((1, True), (2, False)):
        middle.hear(LinkHeard(3, number, ahead(backs_up=backs_up)), float(number))
        tail.hear(LinkHeard(2, number, told_behind(middle.tell(own(1.0), float(number)), 1)), float(number))
        passed.append(tail.back_by_m)
    assert passed == [1.0, 0.0]
