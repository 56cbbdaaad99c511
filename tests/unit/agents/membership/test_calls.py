"""When a robot calls all to line up again, and whom: what it has seen and heard, and what it makes of it."""

from collections.abc import Iterable

import pytest
from agents.membership.calls import ANSWERS, ASKS_S, GAPS, INVITES_S, LISTENS_S, RANK_S, SLEPT_S, Calls
from agents.membership.lining import Lining
from agents.membership.waiting import SLOW_S
from hypothesis import given
from hypothesis import strategies as st
from msgspec.structs import replace
from protocol.epochs import called_epoch

from agents.body.driver import Driver
from agents.liveness.presence import GRACE_S
from agents.strand.strand import COMES_BACK_S
from protocol.frames import Pose
from protocol.keys import WORLD_NUMBER
from protocol.wire.messages import Muster, Odometry, Phase, Turn
from tests.support.stages.calls_stage import MISSION, calls

PATIENCE_S = ANSWERS * MISSION.patience_s
STANDS_S = MISSION.silence_s + MISSION.deadman_s
ROW_S = MISSION.silence_s + MISSION.patience_s
EPOCH = called_epoch(0, 1, 0.0)
HERE = Pose(x_m=0.0, y_m=0.0, heading_rad=0.0)
STANDS = Odometry(t_s=0.0, pose=HERE, moving=False, finished=0, phase=Phase.RUNNING)
ALL = (1, 2, 3, 4, 5)


def lining(answers: Iterable[int], *, robot: int = 1, members: tuple[int, ...] = ALL) -> Lining:
    """One that began at 0, in which robots have answered just before the others' patience is over.

    All who answer have heard each other and the robot itself.
    """
    made, heard = Lining(robot, MISSION, epoch=EPOCH, members=members), {robot, *answers}
    for other in heard - {robot}:
        hear(made, other, heard, PATIENCE_S)
    stands(made)
    return made


def hear(into: Lining, robot: int, hears: Iterable[int], now_s: float, *, number: int = 1) -> None:
    """Another robot announces itself, and whom it has heard."""
    said = Muster(
        number=number, epoch=EPOCH, pose=HERE, members=into.members, hears=tuple(sorted(hears)), t_s=now_s
    )
    into.hear(robot, said, now_s)


def stands(into: Lining) -> None:
    """The robot itself says where it stands, and whom it has heard."""
    driver = Driver(speed_mps=MISSION.speed_mps)
    driver.hear(STANDS)
    into.act(driver, None, 0.0)


# --- whom it calls ----------------------------------------------------------------------------------


def test_members_are_all_robots_that_show_a_token_and_the_caller() -> None:
    epoch, members = calls(2, 4).call(None, 1.0)
    assert members == (1, 2, 4)
    assert epoch == called_epoch(0, 1, 1.0)


def test_a_call_is_newer_than_whatever_has_been_heard() -> None:
    made = calls(2)
    newest = called_epoch(0, 7, 99.0) + 3  # by a clock that is ahead
    made.hear(newest, 1.0)
    made.hear(5, 1.1)
    assert made.call(None, 2.0)[0] > newest


def test_who_has_not_answered_is_left_out_of_the_next_call() -> None:
    after_s = PATIENCE_S + 0.1
    assert calls(2, 3, 4, 5).call(lining([2, 3, 4]), after_s)[1] == (1, 2, 3, 4)


@pytest.mark.parametrize(
    ("knows_of", "since_s", "members"),
    [(EPOCH, ASKS_S, ALL), (EPOCH - 1, ASKS_S, (1, 2, 3, 4)), (EPOCH, ASKS_S + 0.1, (1, 2, 3, 4))],
    ids=["of this call", "of an older one", "of this, but long ago"],
)
def test_who_has_not_answered_but_asks_to_be_called_knowing_of_this_call_is_called_again(
    knows_of: int, since_s: float, members: tuple[int, ...]
) -> None:
    made, after_s = calls(2, 3, 4, 5), PATIENCE_S + 0.1
    made.pleads(5, knows_of, after_s - since_s)
    assert made.call(lining([2, 3, 4]), after_s)[1] == members


def test_who_asks_again_and_again_and_never_answers_is_left_out_in_between() -> None:
    made, called = calls(2, 3, 4, 5), []
    for after_s in (PATIENCE_S + 0.1, PATIENCE_S + 0.2, PATIENCE_S + 0.1 + INVITES_S):
        made.pleads(5, EPOCH, after_s)
        called.append(5 in made.call(lining([2, 3, 4]), after_s)[1])
    assert called == [True, False, True]


def test_before_its_patience_is_over_a_silent_member_is_not_left_out() -> None:
    assert calls(2, 3, 4, 5).call(lining([2, 3, 4]), PATIENCE_S)[1] == ALL


def test_where_the_rest_are_not_more_than_half_all_are_called() -> None:
    after_s = PATIENCE_S + 0.1
    assert calls(2, 3, 4, 5).call(lining([2, 3]), after_s)[1] == (1, 2, 3)
    assert calls(2, 3, 4, 5).call(lining([2]), after_s)[1] == ALL
    assert calls(2).call(lining([], members=(1, 2)), after_s)[1] == (1, 2)


def test_who_shows_no_token_counts_for_nothing() -> None:
    assert calls(2).call(lining([2]), PATIENCE_S + 0.1)[1] == (1, 2)
    assert calls().call(lining([]), PATIENCE_S + 0.1)[1] == (1,)


def test_of_two_that_do_not_both_hear_each_other_the_one_that_is_not_heard_is_left_out() -> None:
    made, waits = calls(2, 3, 4, 5), Lining(1, MISSION, epoch=EPOCH, members=ALL)
    late_s = ANSWERS * PATIENCE_S + 0.1
    for robot in ALL[1:]:
        hear(waits, robot, (1, 3, 4, 5) if robot == 3 else ALL, late_s)
    stands(waits)
    assert made.call(waits, late_s)[1] == (1, 3, 4, 5), "robot 3 may shun robot 2"


def test_of_two_that_are_as_bad_the_one_that_was_left_out_before_is_left_out_again() -> None:
    made, waits = calls(2, 3, 4, 5), Lining(1, MISSION, epoch=EPOCH, members=ALL)
    made.free_at_s((1, 2, 4, 5), 0.0)
    late_s = ANSWERS * PATIENCE_S + 0.1
    for robot in ALL[1:]:
        hear(waits, robot, (1, 3, 4, 5) if robot == 3 else ALL, late_s)
    stands(waits)
    assert made.call(waits, late_s)[1] == (1, 2, 4, 5), "robot 3 may be the one that hears nobody"


@pytest.mark.parametrize(("hardly_heard", "left"), [(2, (1, 3, 4, 5)), (3, (1, 2, 4, 5))])
def test_of_two_that_shun_each_other_the_one_that_is_hardly_heard_is_left_out(
    hardly_heard: int, left: tuple[int, ...]
) -> None:
    waits = Lining(1, MISSION, epoch=EPOCH, members=ALL)
    hears = {2: (1, 2, 4, 5), 3: (1, 3, 4, 5), 4: ALL, 5: ALL}
    for number, now_s in enumerate((1.0, 2.0, PATIENCE_S), start=1):
        for robot in ALL[1:]:
            if robot != hardly_heard or now_s != 2.0:
                hear(waits, robot, hears[robot], now_s, number=number)
    stands(waits)
    assert calls(2, 3, 4, 5).call(waits, PATIENCE_S + 0.1)[1] == left


@pytest.mark.parametrize(("deaf", "hearers"), [(3, (1, 2, 4, 5)), (5, (1, 2, 3, 4))])
def test_a_member_that_others_do_not_hear_is_left_out(deaf: int, hearers: tuple[int, ...]) -> None:
    made = Lining(1, MISSION, epoch=EPOCH, members=ALL)
    for robot in ALL[1:]:
        hear(made, robot, ALL if robot == deaf else hearers, PATIENCE_S)
    stands(made)
    assert calls(2, 3, 4, 5).call(made, PATIENCE_S + 0.1)[1] == hearers


def test_of_two_that_do_not_hear_each_other_the_caller_is_not_the_one_that_is_left_out() -> None:
    made = Lining(1, MISSION, epoch=EPOCH, members=(1, 2, 3))
    hear(made, 3, (1, 2, 3), PATIENCE_S)
    stands(made)
    hear(made, 2, (2, 3), PATIENCE_S)
    assert calls(2, 3).call(made, PATIENCE_S + 0.1)[1] == (1, 3)


tokens = st.sets(st.sampled_from(ALL[1:]))


@given(tokens, tokens, tokens, tokens)
def test_no_two_calls_that_see_the_same_tokens_have_no_member_in_common(
    shown: set[int], one_hears: set[int], others: set[int], other_hears: set[int]
) -> None:
    after_s = PATIENCE_S + 0.1
    one = set(calls(*shown).call(lining(one_hears), after_s)[1])
    for other in shown:
        there = calls(*(shown - {other} | {1}), robot=other)
        heard = (others | other_hears) - {other}
        assert one & set(there.call(lining(heard, robot=other), after_s)[1])


def test_who_makes_nothing_of_its_turn_is_left_out_of_the_next_call() -> None:
    made, waits, turn = (
        calls(2, 3, 4, 5),
        Lining(1, MISSION, epoch=EPOCH, members=ALL),
        Turn(number=1, robot=3),
    )
    waits.settled_at_s = 0.0
    reasons = []
    for beat in range(round(10.0 * SLOW_S) + 3):
        now_s = beat / 10.0
        for robot in ALL[1:]:
            gives = turn if robot == 2 else None
            said = Muster(
                number=1 + beat,
                epoch=EPOCH,
                pose=HERE,
                members=ALL,
                hears=ALL,
                gives=gives,
                t_s=now_s,
                free_s=0.0,
            )
            waits.hear(robot, said, now_s)
        stands(waits)
        reasons.append(made.wants_another(waits, now_s))
    assert reasons[-1] == "robot 3 keeps the others waiting"
    assert set(reasons[: round(10.0 * SLOW_S)]) == {None}
    assert made.call(waits, now_s)[1] == (1, 2, 4, 5)


# --- when it calls ----------------------------------------------------------------------------------


def test_a_lining_up_may_come_to_something_as_long_as_all_answer() -> None:
    made = calls(2, 3, 4, 5)
    assert made.wants_another(lining([2, 3, 4, 5]), 2.0 * PATIENCE_S) is None


def test_a_member_that_is_lost_is_not_waited_for() -> None:
    made, waits = calls(2, 3, 4, 5), Lining(1, MISSION, epoch=EPOCH, members=ALL)
    made.presence.go(3, "a", 1.0)
    assert made.wants_another(waits, 1.0 + GRACE_S / 2.0) is None
    assert made.wants_another(waits, 1.0 + GRACE_S) == "robot 3 is lost"


@pytest.mark.parametrize("rank", [0, 1, 3])
def test_of_those_that_may_call_each_waits_for_those_before_it(rank: int) -> None:
    robot = ALL[rank]
    made = calls(*(other for other in ALL if other != robot), robot=robot)
    waits = Lining(robot, MISSION, epoch=EPOCH, members=ALL)
    for other in ALL[:4]:
        hear(waits, other, ALL, 10.0)
    patience_s = PATIENCE_S + rank * RANK_S
    assert made.wants_another(waits, patience_s) is None
    assert made.wants_another(waits, patience_s + 0.01) == "robot 5 does not answer"


def test_who_misses_what_others_say_waits_for_longer_before_it_says_that_one_does_not_answer() -> None:
    made, waits = calls(2, 3), Lining(1, MISSION, epoch=EPOCH, members=(1, 2, 3))
    missed_s = 5.0
    for number, now_s in enumerate((0.1, 0.1 + missed_s, 5.2, 9.0), start=1):
        hear(waits, 2, (1, 2, 3), now_s, number=number)
    hear(waits, 3, (1, 2, 3), 0.1)
    stands(waits)
    patience_s = 0.1 + GAPS * missed_s
    assert patience_s > PATIENCE_S
    assert [made.wants_another(waits, at_s) for at_s in (patience_s, patience_s + 0.1)] == [
        None,
        "robot 3 does not answer",
    ]
    assert made.call(waits, patience_s + 0.1)[1] == (1, 2)


def test_members_that_do_not_hear_each_other_are_a_reason_when_they_had_time_to() -> None:
    made, waits = calls(2, 3), Lining(1, MISSION, epoch=EPOCH, members=(1, 2, 3))
    for robot in (2, 3):
        hear(waits, robot, (1, robot), PATIENCE_S)
    stands(waits)
    assert made.wants_another(waits, PATIENCE_S) is None
    assert made.wants_another(waits, PATIENCE_S + 0.1) == "some members do not hear each other"


def test_who_hears_nobody_does_not_call() -> None:
    made = calls(2)
    made.hear(0, 5.0)
    limit_s = 5.0 + 2.0 * MISSION.silence_s
    assert [made.is_heard(now_s) for now_s in (5.0, limit_s, limit_s + 0.1)] == [True, True, False]


def test_who_is_alone_calls_though_it_hears_nobody_but_not_when_it_is_cut_off() -> None:
    made = calls()
    alone = [made.is_heard(99.0)]
    made.presence.go(WORLD_NUMBER, "a", 99.0)
    alone.append(made.is_heard(99.0))
    assert alone == [True, False]


def test_who_has_slept_listens_before_it_believes_a_silence() -> None:
    made = calls(2)
    awake = []
    for now_s in (
        0.0,
        0.1,
        0.1 + SLEPT_S,
        20.0,
        20.0 + 0.4 * LISTENS_S,
        20.0 + 0.9 * LISTENS_S,
        20.0 + LISTENS_S,
    ):
        made.enter(now_s)
        awake.append(made.is_awake)
    assert awake == [True, True, True, False, False, False, True]


# --- who is left out must stand ---------------------------------------------------------------------


def test_where_nobody_is_left_out_all_may_drive_as_soon_as_all_are_bound() -> None:
    assert calls(2, 3, 4, 5).free_at_s(ALL, 7.0) == 7.0


def test_who_is_left_out_stands_when_its_lease_and_then_its_body_must_have_run_out() -> None:
    made = calls(2, 3, 4, 5)
    made.presence.go(5, "a", 2.0)
    assert made.free_at_s((1, 2, 3, 4), 6.5) == 6.5 + STANDS_S
    assert made.free_at_s((1, 2, 3, 4), 20.0) == 20.0


def settled(made: Calls, waits: Lining, driver: Driver, now_s: float, *, ordered: int) -> float | None:
    """When members may drive, as far as is known when an odometry comes that knows of so many orders."""
    number = driver.drive.number
    driver.hear(replace(STANDS, t_s=now_s, ordered=ordered, finished=min(ordered, number)))
    made.attend(waits, driver, now_s)
    return waits.settled_at_s


def test_since_when_it_stands_is_dated_by_an_odometry_that_knows_of_an_order_given_when_all_were_bound() -> (
    None
):
    made, driver = calls(2, 3, 4), Driver(speed_mps=MISSION.speed_mps)
    waits = lining(ALL[1:4], members=ALL[:4])
    old = settled(made, waits, driver, 7.0, ordered=0)
    asks = driver.drive
    old_too = settled(made, waits, driver, 7.1, ordered=asks.number - 1)
    assert (old, old_too, driver.drive.number) == (None, None, asks.number), "they may be far from new"
    assert (asks.target, asks.epoch) == (None, EPOCH)
    assert settled(made, waits, driver, 9.0, ordered=asks.number) == 9.0 + STANDS_S


def test_where_nobody_is_left_out_no_order_has_to_be_heard_of() -> None:
    driver = Driver(speed_mps=MISSION.speed_mps)
    waits = lining(ALL[1:])
    assert settled(calls(2, 3, 4, 5), waits, driver, 7.0, ordered=0) == 7.0
    assert driver.drive.number == 0


def test_who_is_left_out_may_come_back_as_long_as_it_shows_a_token_and_for_a_while_after_that() -> None:
    made, driver = calls(2, 3, 4, 5), Driver(speed_mps=MISSION.speed_mps)
    waits = lining(ALL[1:3], members=ALL[:3])
    driver.hear(STANDS)
    made.presence.go(4, "a", 1.0)

    def may_at(now_s: float) -> bool:
        made.attend(waits, driver, now_s)
        return waits.others_may_come_back

    shows = may_at(3.0 * COMES_BACK_S)
    made.presence.go(5, "a", 50.0)
    gone = [may_at(now_s) for now_s in (50.0, 49.9 + COMES_BACK_S, 50.0 + COMES_BACK_S)]
    made.presence.come(5, "b", 70.0)
    assert [shows, *gone, may_at(99.0)] == [True, True, True, False, True]


def test_members_go_on_only_as_long_as_they_may_leave_out_the_others_that_show_tokens() -> None:
    made = calls()
    before = made.may_go_on((1,), 1.0)
    for robot in (2, 3):
        made.presence.come(robot, "a", 2.0)
    noticed = [made.may_go_on((1,), now_s) for now_s in (2.0, 3.0)]
    assert (before, noticed) == (True, [True, False]), "it led alone while no other token was shown"
    assert made.may_go_on((1, 2), 9.0), "two of three"


@pytest.mark.parametrize("left_out", [1, 2, 3])
def test_of_a_row_that_is_left_out_each_may_come_to_stand_when_the_one_beside_it_has(left_out: int) -> None:
    members = ALL[: 5 - left_out]
    assert calls(2, 3, 4, 5).free_at_s(members, 7.0) == 7.0 + STANDS_S + (left_out - 1) * ROW_S


def test_who_was_left_out_before_is_not_waited_for_again_but_for_as_long_as_then() -> None:
    made = calls(2, 3, 4, 5)
    waits = [made.free_at_s((1, 2, 3, 4), now_s) for now_s in (7.0, 8.0, 20.0)]
    assert waits == [7.0 + STANDS_S, 7.0 + STANDS_S, 20.0]


def test_who_was_called_in_meanwhile_and_is_left_out_again_is_waited_for_again() -> None:
    made = calls(2, 3, 4, 5)
    waits = [
        made.free_at_s(members, now_s) for members, now_s in ((ALL[:4], 7.0), (ALL, 20.0), (ALL[:4], 30.0))
    ]
    assert waits == [7.0 + STANDS_S, 20.0, 30.0 + STANDS_S]


def test_who_has_stood_aside_waits_for_all_that_are_left_out_whoever_was_so_before() -> None:
    made = calls(2, 4, 5)
    made.free_at_s((1, 2, 4, 5), 10.0)
    made.stand_aside(20.0)
    assert made.free_at_s((1, 2, 4, 5), 27.4) == 27.4 + STANDS_S
