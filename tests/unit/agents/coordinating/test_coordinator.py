"""When a coordinator goes on with its view, and whom it waits for until then."""

from protocol.fence import Cause, May
from tests.support.stages.coordinated import BEGAN_S, BEHIND, OWN, START, TIMING, View, report, with_turns

LATE_S = BEGAN_S + TIMING.reports_s + 1.0


def reported(view: View, *robots: int) -> View:
    for robot in robots:
        view.hear(robot, report(robot, START[robot]))
    view.act()
    return view


def test_nothing_goes_on_before_the_coordinator_has_reported_to_itself_however_late_it_is() -> None:
    """It counts for the next formation what its own report says."""
    view = reported(View(), 2, 3)
    view.act(until_s=LATE_S)
    assert not view.drafted.order
    assert reported(view, OWN).drafted.order


def test_a_view_names_the_robots_that_it_waits_for_in_each_phase_and_since_when() -> None:
    view = reported(View(), OWN, 2)
    assert (view.drafted.awaited, view.drafted.since_s) == ({3, 4}, BEGAN_S), "they have not reported"
    assert reported(view, 3, 4).drafted.awaited == {2, 3, 4}, "they look at their legs"
    assert view.drafted.since_s == view.now_s
    view.look()
    view.act()
    assert (view.fence.robot, view.drafted.awaited) == (2, {2}), "it has the turn"
    view = with_turns()
    view.hear(3, report(3, BEHIND[3], number=4, turn=2, ended=2, placed=True))
    view.act()
    view.hear(4, report(4, START[4], number=4, turn=3, ended=3))
    view.act()
    view.act()
    assert (view.fence.may, view.drafted.awaited) == (May.NOBODY, {2, 3}), "their places may be old"
    for robot in (2, 3):
        view.hear(robot, report(robot, BEHIND[robot], number=5, turn=4, ended=robot - 1, placed=True))
    view.act()
    assert (view.fence.may, view.drafted.in_place, view.drafted.awaited) == (May.ALL, (1, 2, 3), set())


def test_no_formation_is_made_of_a_place_from_before_its_robots_turn_however_long_the_robot_repeats_it() -> (
    None
):
    """A robot that is heard is not lost. It may hear no odometry, so that it can tell no newer place."""
    view = with_turns()
    view.hear(3, report(3, BEHIND[3], number=4, turn=2, ended=2, placed=True))
    view.act()
    view.hear(4, report(4, START[4], number=4, turn=3, ended=3))
    while view.now_s < BEGAN_S + 2.0 * TIMING.looks_s:
        view.act()
        for robot in (2, 3):
            view.hear(robot, report(robot, BEHIND[robot], number=4, turn=robot - 1, ended=1, placed=True))
    assert (view.fence.may, view.drafted.awaited) == (May.NOBODY, {2, 3})


def test_robots_that_the_view_waits_for_are_told_that_they_had_a_turn_until_they_tell_a_newer_place() -> None:
    view = with_turns()
    view.hear(3, report(3, BEHIND[3], number=4, turn=2, ended=2, placed=True))
    view.act()
    view.hear(4, report(4, START[4], number=4, turn=3, ended=3))
    view.act(until_s=view.now_s + 0.2)
    view.answers.clear()
    view.act()
    assert {robot: answer.after_turn for robot, answer in view.answers.items()} == {2: 1, 3: 2}
    view.hear(2, report(2, BEHIND[2], number=5, turn=4, ended=1, placed=True))
    view.act()
    view.answers.clear()
    view.act()
    assert view.answers.keys() == {3}


def test_a_robot_that_reports_while_another_one_has_the_turn_gets_one_when_the_draft_has_begun_again() -> (
    None
):
    view = reported(View(), 1, 2, 3)
    view.act(until_s=LATE_S)
    view.look()
    view.act()
    assert (view.fence.robot, reported(view, 4).drafted.order) == (2, (1, 2, 3))
    view.hear(2, report(2, BEHIND[2], number=4, turn=1, ended=1, placed=True))
    view.act()
    assert (view.fence.may, view.drafted.awaited) == (May.NOBODY, {2}), "its place may be old"
    view.hear(2, report(2, BEHIND[2], number=5, turn=2, ended=1, placed=True))
    view.act()
    assert view.drafted.order == (1, 2, 3, 4)


def test_before_a_view_leaves_robots_out_it_waits_in_its_first_seconds_for_those_that_were_there_lately() -> (
    None
):
    for went_s, until_s in ((None, TIMING.comes_back_s), (-0.4, TIMING.comes_back_s - 0.4), (-9.0, 0.0)):
        view = View(Cause.NEIGHBOUR_LOST)
        if went_s is not None:
            view.suspicion.presence.go(4, "a", BEGAN_S + went_s)
        reported(view, 1, 2, 3)
        view.act(until_s=BEGAN_S + TIMING.reports_s + 0.1)
        view.look(2)
        view.act()
        view.hear(3, report(3, START[3], number=4, turn=1, ended=1))
        view.act(until_s=max(view.now_s, BEGAN_S + until_s - 0.3))
        assert view.drafted.awaited == ({4} if until_s else set())
        view.act(until_s=BEGAN_S + until_s + 0.3)
        assert (view.fence.may, view.drafted.in_place) == (May.ALL, (1, 2))


def test_a_newer_map_than_the_leaders_is_asked_of_the_robot_that_has_it_and_not_waited_for_long() -> None:
    view = View(Cause.NEIGHBOUR_LOST)
    view.hear(3, report(3, START[3], map_number=7))
    reported(view, 1, 2, 4).look(2, 3, 4)
    view.hear(3, report(3, START[3], number=3, map_number=7))
    view.act()
    assert {robot for robot, answer in view.answers.items() if answer.wants_map} == {3}
    assert (view.fence.may, view.drafted.awaited) == (May.NOBODY, {3})
    view.act(until_s=view.now_s + TIMING.looks_s + 0.2)
    assert view.fence.may is May.ALL


def test_a_robot_that_was_driving_as_another_one_was_lost_has_time_to_tell_where_it_stands() -> None:
    view = with_turns()
    view.act(until_s=view.now_s + TIMING.looks_s + 1.0)  # robot 3 drives in its turn, and has nothing to tell
    view.suspicion.presence.go(4, "a", view.now_s)
    view.act(until_s=view.now_s + 1.0)
    assert (view.fence.may, view.drafted.awaited) == (May.NOBODY, {2, 3})
    view.hear(2, report(2, BEHIND[2], number=5, turn=3, ended=1, placed=True))
    view.hear(3, report(3, BEHIND[3], number=5, turn=3))
    view.act()
    assert set(view.drafted.order) == {1, 2, 3}
