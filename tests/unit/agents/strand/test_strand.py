"""Places in the strand as conversations: what a robot sends, and when a link counts as silent."""

import pytest
import shapely
from agents.strand.forming import lined_up
from msgspec.structs import replace

from agents.commands import Note, Tell
from agents.events import LinkHeard
from agents.strand.grants import GRANT_M_MIN
from agents.strand.leader import Leader
from agents.strand.strand import SILENT_SHARE_MAX, URGENT_S, Strand
from protocol.frames import Point, Pose, Vertex
from protocol.mission import Law
from protocol.timeline import LinkHeard as LinkHeardAgain
from protocol.timeline import LinkSilent, StepPlanned
from protocol.wire.messages import AheadState, BehindState
from tests.support.stages.one_step import plan, under
from tests.support.stages.strand_stage import (
    HEARTBEAT_S,
    KEEP_M,
    KNOWN,
    MISSION,
    ORDER,
    PLACES,
    SILENCE_S,
    ahead,
    behind,
    granted,
    leading,
    own,
    place,
    told_ahead,
    told_behind,
)


def test_all_robots_measure_the_same_path_from_the_tail_to_the_leader() -> None:
    strands = {robot: place(robot) for robot in ORDER}
    assert [strands[robot].start_m for robot in (1, 2, 3)] == [0.0, 1.0, 2.0]
    assert {strand.path.told_from(0, 9) for strand in strands.values()} == {strands[1].path.told_from(0, 9)}


def test_each_robot_knows_its_two_neighbours_and_who_stands_ahead() -> None:
    leader, middle, tail = (place(robot) for robot in ORDER)
    links = [
        [link.neighbour for link in (each.ahead, each.behind) if link] for each in (leader, middle, tail)
    ]
    assert links == [[2], [3, 1], [2]]
    assert told_behind(leader.tell(own(2.0), 0.0), 2).lineage == ()
    assert told_behind(middle.tell(own(1.0), 0.0), 1).lineage == (3,)


def test_a_robot_alone_has_no_silent_link_and_sends_no_state() -> None:
    alone = lined_up(1, (1,), PLACES, MISSION, 0.0)
    assert not alone.silent
    assert alone.watch(99.0) == []
    assert alone.tell(own(0.0), 0.0) == []
    assert (alone.grants.tail_m, alone.grants.stretch_m) == (0.0, 0.0)


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


def test_a_leader_keeps_off_the_place_of_a_robot_that_has_no_grant_yet() -> None:
    # A robot of radius 0 is invisible to scans, and 0.33 m behind is too little for a grant.
    pair = under(Law.CERTIFIED, robots=2, separation_m=0.3, goal=Point(x_m=-2.0, y_m=0.0), directions=360)
    places = {robot: Pose(x_m=0.33 * robot, y_m=0.0, heading_rad=0.0) for robot in (1, 2)}
    strand = lined_up(2, (2, 1), places, pair, 0.0)
    strand.tell(own(strand.start_m), 0.0)
    ground = strand.grants.ground
    planned = plan(Leader(pair, places[2]), [], pair, ground, at=places[2])
    assert isinstance(planned, StepPlanned)
    step = shapely.LineString([(planned.x_m, planned.y_m), (planned.target.x_m, planned.target.y_m)])
    assert step.distance(shapely.Point(places[1].x_m, 0.0)) >= strand.grants.keep_m - 1e-9


def test_a_robot_without_a_robot_behind_keeps_off_no_ground() -> None:
    assert lined_up(1, (1,), PLACES, MISSION, 0.0).grants.keep_m == 0.0


def test_the_tail_grants_nothing() -> None:
    strand = place(1)
    assert granted(strand.tell(own(0.0), 0.0)) == []


def test_the_stretch_is_the_part_of_the_grant_that_the_robot_behind_has_not_driven() -> None:
    strand = place(3)
    strand.tell(own(2.0), 0.0)
    assert strand.grants.stretch_m == 0.0
    strand.hear(LinkHeard(2, 1, behind(progress_m=1.0)), 0.0)
    assert strand.grants.stretch_m == pytest.approx(1.0 - KEEP_M)
    strand.hear(LinkHeard(2, 2, behind(progress_m=1.9)), 0.0)
    assert strand.grants.stretch_m == 0.0


# --- telling ----------------------------------------------------------------------------------------


def told_to(strand: Strand, now_s: float) -> list[int]:
    return sorted(command.robot for command in strand.tell(own(1.0), now_s) if isinstance(command, Tell))


def test_a_robot_sends_its_state_to_both_neighbours_at_once_and_on_every_heartbeat() -> None:
    strand = place(2)
    told = [told_to(strand, 0.0)]
    strand.hear(LinkHeard(3, 1, ahead(echo_s=0.01)), 0.02)
    strand.hear(LinkHeard(1, 1, behind(echo_s=0.01)), 0.02)
    told += [told_to(strand, beat * HEARTBEAT_S) for beat in (0.4, 1.0, 1.4, 2.0)]
    assert told == [[1, 3], [], [1, 3], [], [1, 3]]


def test_a_robot_sends_more_often_until_both_answer_and_when_an_answer_is_missing() -> None:
    strand = place(2)
    told = [told_to(strand, 0.0)]
    strand.hear(LinkHeard(3, 1, ahead(echo_s=0.01)), 0.02)
    told += [told_to(strand, now_s) for now_s in (0.05, URGENT_S)]
    strand.hear(LinkHeard(1, 1, behind(echo_s=0.02)), URGENT_S)
    told += [
        told_to(strand, now_s) for now_s in (2.0 * URGENT_S, 2.5 * HEARTBEAT_S, 2.5 * HEARTBEAT_S + 0.11)
    ]
    assert told == [[1, 3], [], [1, 3], [], [1, 3], [1, 3]]


def test_a_strand_is_quiet_since_all_robots_behind_stand_and_the_tail_has_not_moved() -> None:
    strand, middle = place(3), place(2)
    told = []
    for number, (now_s, tail_stands) in enumerate([(1.0, False), (2.0, True), (3.0, True)], start=1):
        middle.hear(LinkHeard(1, number, behind(stand=tail_stands)), now_s)
        state = told_ahead(middle.tell(own(1.0), now_s), 3)
        strand.hear(LinkHeard(2, number, state), now_s)
        told.append((state.stand, strand.quiet_s(now_s)))
    assert told == [(False, 0.0), (True, 1.0), (True, 2.0)]
    moving = told_ahead(middle.tell(own(1.1, stands=False), 4.0), 3)
    strand.hear(LinkHeard(2, 4, moving), 4.0)
    assert strand.quiet_s(4.5) == 0.5


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
    strand.hear(LinkHeard(1, 1, behind(progress_m=0.4, tail_m=0.4)), 0.5)
    assert (before, told_ahead(strand.tell(own(1.0), 1.0), 3).tail_progress_m) == (0.0, 0.4)


def test_the_tail_sends_its_own_progress_as_the_tails() -> None:
    assert told_ahead(place(1).tell(own(0.6), 0.0), 2).tail_progress_m == 0.6


def test_no_robot_reports_a_tail_ahead_of_itself() -> None:
    strand = place(2)
    strand.hear(LinkHeard(1, 1, behind(progress_m=0.4, tail_m=9.0)), 0.0)
    assert told_ahead(strand.tell(own(1.0), 0.0), 3).tail_progress_m == 1.0


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


@pytest.mark.parametrize(
    ("robot", "state"),
    [
        (3, ahead(epoch=0, authority_m=1.9)),
        (3, ahead(epoch=2, authority_m=1.9)),
        (1, ahead(authority_m=1.9)),
        (7, ahead(authority_m=1.9)),
        (3, behind(tail_m=0.9, progress_m=0.9)),
        (7, behind(tail_m=0.9, progress_m=0.9)),
        (1, behind(epoch=2, tail_m=0.9, progress_m=0.9)),
    ],
)
def test_states_of_another_epoch_a_stranger_or_the_wrong_side_are_void(
    robot: int, state: AheadState | BehindState
) -> None:
    strand = place(2)
    assert strand.hear(LinkHeard(robot, 1, state), 0.1) == []
    assert (strand.authority_m, strand.grants.tail_m) == (1.0, 0.0)
    assert (len(strand.path), strand.silent) == (KNOWN, True)
    assert strand.watch(SILENCE_S + 0.1) != []


# --- silence ----------------------------------------------------------------------------------------


def test_a_link_is_silent_until_the_neighbour_has_echoed_something() -> None:
    strand = lined_up(2, ORDER, PLACES, MISSION, 1.0)
    silent = [strand.silent]
    strand.hear(LinkHeard(3, 1, ahead(authority_m=1.0, echo_s=1.05)), 1.1)
    silent.append(strand.silent)
    strand.hear(LinkHeard(1, 1, behind()), 1.1)
    silent.append(strand.silent)
    strand.hear(LinkHeard(1, 2, behind(echo_s=1.05)), 1.2)
    silent.append(strand.silent)
    assert silent == [True, True, True, False]


def test_each_neighbour_gets_an_echo_of_its_newest_state() -> None:
    strand = place(2)
    strand.hear(LinkHeard(3, 1, replace(ahead(), t_s=7.0)), 1.0)
    strand.hear(LinkHeard(1, 1, replace(behind(), t_s=5.0)), 1.0)
    strand.hear(LinkHeard(1, 2, replace(behind(), t_s=4.0)), 1.0)
    commands = strand.tell(own(1.0), 1.1)
    assert [(said.t_s, said.echo_s) for said in (told_ahead(commands, 3), told_behind(commands, 1))] == [
        (1.1, 7.0),
        (1.1, 5.0),
    ]


def test_a_link_that_works_one_way_only_is_silent_at_both_ends() -> None:
    leader, follower = place(3), lined_up(2, (3, 2), PLACES, MISSION, 0.0)
    silences: dict[int, list[bool]] = {3: [], 2: []}
    for beat in range(1, 12):
        now_s = beat * HEARTBEAT_S
        leader.watch(now_s)
        follower.watch(now_s)
        for command in leader.tell(own(2.0), now_s):
            if isinstance(command, Tell):
                follower.hear(LinkHeard(3, beat, command.state), now_s)
        answer = told_ahead(follower.tell(own(1.0), now_s), 3)
        if beat <= 2:  # from then on all messages in this direction are lost
            leader.hear(LinkHeard(2, beat, answer), now_s)
        silences[3].append(leader.silent)
        silences[2].append(follower.silent)
    assert [robot_silent[2] for robot_silent in silences.values()] == [False, False]
    assert [robot_silent[-1] for robot_silent in silences.values()] == [True, True]


def test_a_silence_and_its_end_are_each_recorded_once() -> None:
    strand = place(3)
    strand.hear(LinkHeard(2, 1, behind()), 0.0)
    assert strand.watch(SILENCE_S) == []
    (noted,) = strand.watch(SILENCE_S + 0.5)
    assert noted == Note(LinkSilent(neighbour=2, silent_s=SILENCE_S + 0.5))
    assert strand.watch(9.0) == []
    assert strand.silent
    assert strand.hear(LinkHeard(2, 2, behind(echo_s=9.8)), 10.0) == [Note(LinkHeardAgain(neighbour=2))]
    assert strand.hear(LinkHeard(2, 3, behind(echo_s=9.9)), 10.1) == []
    assert strand.watch(9.9 + SILENCE_S) == []
    assert len(strand.watch(10.0 + SILENCE_S)) == 1


def test_each_link_falls_silent_independently() -> None:
    strand = place(2)
    strand.hear(LinkHeard(3, 1, ahead(authority_m=1.0)), 0.0)
    strand.hear(LinkHeard(1, 1, behind(echo_s=0.75)), 0.75)
    assert strand.watch(1.5) == [Note(LinkSilent(neighbour=3, silent_s=1.5))]
    assert strand.watch(2.0) == [Note(LinkSilent(neighbour=1, silent_s=1.25))]


def after_a_minute(*, ahead_every_s: float, behind_every_s: float) -> Strand:
    """The middle of three robots, whose neighbours report at these periods."""
    strand = place(2)
    for tenth in range(1, 600):
        now_s = tenth / 10.0
        if tenth % round(10.0 * ahead_every_s) == 0:
            strand.hear(LinkHeard(3, tenth, ahead(echo_s=now_s)), now_s)
        if tenth % round(10.0 * behind_every_s) == 0:
            strand.hear(LinkHeard(1, tenth, behind(echo_s=now_s)), now_s)
        strand.watch(now_s)
    return strand


def test_a_neighbour_that_falls_silent_again_and_again_keeps_the_strand_waiting() -> None:
    strand = after_a_minute(ahead_every_s=HEARTBEAT_S, behind_every_s=2.5 * SILENCE_S)
    assert strand.ahead is not None
    assert strand.behind is not None
    assert strand.behind.silent_s(59.9) < MISSION.patience_s, "it was never silent for long"
    assert [strand.keeps_waiting(link) for link in (strand.ahead, strand.behind)] == [False, True]


def test_if_both_neighbours_fall_silent_neither_keeps_the_strand_waiting() -> None:
    strand = after_a_minute(ahead_every_s=2.5 * SILENCE_S, behind_every_s=2.5 * SILENCE_S)
    assert [strand.keeps_waiting(link) for link in strand.links] == [False, False]
    assert [strand.stands_out(link) for link in strand.links] == [False, False]


def test_a_robot_breaks_its_only_link_only_after_a_long_silence() -> None:
    leader = place(3)
    for second in range(1, 60):
        leader.hear(LinkHeard(2, second, behind(echo_s=second - SILENCE_S)), float(second))
        leader.watch(second + 0.9)
    (link,) = leader.links
    assert link.silent_share > SILENT_SHARE_MAX
    assert not leader.keeps_waiting(link)


@pytest.mark.parametrize("number", [1, 2])
def test_an_old_state_does_not_end_a_silence(number: int) -> None:
    strand = place(3)
    strand.hear(LinkHeard(2, 2, behind()), 0.0)
    strand.watch(5.0)
    assert strand.hear(LinkHeard(2, number, behind(echo_s=4.9)), 5.0) == []
    assert strand.silent


def test_a_new_state_with_a_long_delay_does_not_end_a_silence() -> None:
    strand = place(3)
    strand.hear(LinkHeard(2, 1, behind()), 0.0)
    strand.watch(5.0)
    assert strand.hear(LinkHeard(2, 2, behind(echo_s=5.0 - SILENCE_S - 0.1)), 5.0) == []
    assert strand.silent


def test_a_robot_that_was_frozen_notices_the_silence_before_it_uses_any_message() -> None:
    strand = place(3)
    strand.hear(LinkHeard(2, 1, behind()), 0.0)
    noted = strand.watch(60.0) + strand.hear(LinkHeard(2, 2, behind(echo_s=59.5)), 60.0)
    assert [type(command.record) for command in noted if isinstance(command, Note)] == [
        LinkSilent,
        LinkHeardAgain,
    ]
