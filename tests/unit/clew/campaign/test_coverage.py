from clew.campaign.coverage import never, sometimes
from clew.campaign.coverage_names import Sometimes
from protocol.faults.plan import Plan
from protocol.faults.rules import Burst, Drop, Kill, Partition, StepPoint
from protocol.frames import Point
from protocol.keys import WORLD
from protocol.timeline import (
    Entry,
    FaultInjected,
    LinkBroken,
    MusterCalled,
    MusterJoined,
    OrderAccepted,
    OrderRefused,
    Record,
    RobotRestarted,
    StrandFormed,
    StrandHealed,
    StrandReversed,
)

HERE = Point(x_m=0.0, y_m=0.0)
PLAN = Plan(
    name="p",
    rules=(
        Kill(name="at", target="leader", point=StepPoint.AFTER_PLAN),
        Drop(name="bursts", burst=Burst(enter=0.1, leave=0.1, loss=1.0)),
        Partition(name="cut", group=("r1",), others=("r2",)),
        Partition(name="off", group=("r1",), others=("router",)),
    ),
)


Told = tuple[float, str, Record]


def counted(*told: Told) -> dict[str, int]:
    entries = [(source, Entry(n=1, t_s=t_s, hlc="", record=record)) for t_s, source, record in told]
    return sometimes(entries, PLAN)


def struck(fault: str, process: str, rule: str = "kill-1") -> FaultInjected:
    return FaultInjected(fault=fault, rule=rule, process=process)


def formed(epoch: int, *order: int) -> StrandFormed:
    return StrandFormed(epoch=epoch, sensed=False, order=order, path_length_m=1.0)


def accepted(robot: int, epoch: int) -> OrderAccepted:
    return OrderAccepted(
        robot=robot, number=1, epoch=epoch, step=0, x_m=0.0, y_m=0.0, target=HERE, reach_m=0.0
    )


def test_a_leader_killed_between_a_call_and_its_healing_is_one_killed_during_a_succession() -> None:
    before: list[Told] = [
        (0.0, "r1", formed(1, 1, 2, 3)),
        (1.0, "r2", MusterCalled(epoch=5, members=(2, 3), why="")),
    ]
    after: list[Told] = [(1.0, "r2", MusterJoined(epoch=5)), (1.2, "r2", formed(6, 2, 3))]
    healed: list[Told] = [(1.3, "r2", StrandHealed(epoch=6, members=(2, 3)))]
    kill = (2.0, WORLD, struck("kill", "r2"))
    assert counted(*before, *after, kill)[Sometimes.LEADER_KILLED_IN_SUCCESSION] == 1
    quiet = counted(*before, *after, *healed, kill)
    assert Sometimes.LEADER_KILLED_IN_SUCCESSION not in quiet
    assert quiet[Sometimes.LEADER_KILLED] == 1


def test_a_zombie_is_a_thawed_robot_whose_body_gets_an_order_while_others_have_gone_on() -> None:
    told: list[Told] = [
        (0.0, "r1", formed(1, 1, 2, 3)),
        (1.0, WORLD, struck("freeze", "r1")),
        (3.0, "r2", formed(6, 2, 3)),
        (5.0, WORLD, struck("thaw", "r1")),
    ]
    assert counted(*told, (5.1, WORLD, accepted(1, 1)))[Sometimes.ZOMBIE_SPOKE] == 1
    joined = (5.05, "r1", MusterJoined(epoch=9))
    assert Sometimes.ZOMBIE_SPOKE not in counted(*told, joined, (5.1, WORLD, accepted(1, 9)))


def test_two_that_stand_beside_each_other_and_die_at_once_are_told_from_two_that_do_not() -> None:
    strand = (0.0, "r1", formed(1, 1, 2, 3))
    one = (1.0, WORLD, struck("kill", "r1"))
    assert Sometimes.TWO_NEIGHBOURS_KILLED in counted(strand, one, (1.0, WORLD, struck("kill", "r2")))
    assert Sometimes.TWO_NEIGHBOURS_KILLED not in counted(strand, one, (1.0, WORLD, struck("kill", "r3")))


def test_calls_cross_where_the_second_caller_has_not_joined_the_first() -> None:
    first = (1.0, "r1", MusterCalled(epoch=5, members=(1, 2), why=""))
    second = (1.1, "r2", MusterCalled(epoch=7, members=(1, 2), why=""))
    assert counted(first, second)[Sometimes.CALLS_CROSSED] == 1
    assert Sometimes.CALLS_CROSSED not in counted(first, (1.05, "r2", MusterJoined(epoch=5)), second)


def test_a_token_is_lost_in_vain_where_its_process_was_not_struck() -> None:
    broken = (2.0, "r1", LinkBroken(neighbour=2, cause="token", silent_s=0.5))
    assert counted(broken)[Sometimes.FALSE_TOKEN_LOSS] == 1
    assert Sometimes.FALSE_TOKEN_LOSS not in counted((1.0, WORLD, struck("kill", "r2")), broken)


def test_what_else_a_timeline_tells_is_counted() -> None:
    counts = counted(
        (0.0, "r1", formed(1, 1, 2)),
        (0.5, "r1", StrandReversed(epoch=1, cut_m=0.0, end_m=1.0, back_by_m=1.0)),
        (1.0, WORLD, struck("kill", "r1", "at")),
        (1.5, "r2", MusterCalled(epoch=5, members=(2,), why="")),
        (1.6, WORLD, struck("kill", "router")),
        (2.0, WORLD, OrderRefused(robot=1, number=1, reason="order 1 is void: epoch 1 is over, now 5")),
        (2.1, WORLD, OrderRefused(robot=1, number=1, reason="order 1 is void: its basis is 2 s old")),
        (3.0, WORLD, RobotRestarted(robot=1)),
        (3.5, "r2", FaultInjected(fault="partition", rule="p", key="muster/1", number=3)),
        (3.6, "r2", FaultInjected(fault="drop", rule="bursts", key="link/1/2", number=3)),
        (4.0, "r1", formed(9, 2, 1)),
    )
    assert set(counts) >= {
        Sometimes.KILLED_AFTER_PLAN,
        Sometimes.KILLED_IN_REVERSAL,
        Sometimes.ROUTER_LOST_IN_MUSTER,
        Sometimes.STALE_EPOCH_REFUSED,
        Sometimes.STALE_ORDER_REFUSED,
        Sometimes.RESTART_JOINED,
        Sometimes.CUT_WHILE_LINING_UP,
        Sometimes.LOST,
        Sometimes.LOST_IN_BURST,
    }
    assert Sometimes.DELAYED.value in never(counts)
    assert Sometimes.LOST.value not in never(counts)


def called(epoch: int, *members: int) -> MusterCalled:
    return MusterCalled(epoch=epoch, members=members, why="")


def test_two_calls_meet_where_a_robot_joins_one_whose_own_call_left_it_out_as_it_left_that_out() -> None:
    apart: list[Told] = [
        (1.0, "r3", called(5, 3)),
        (1.0, "r3", MusterJoined(epoch=5)),
        (2.0, "r1", called(7, 1, 2)),
        (2.0, "r1", MusterJoined(epoch=7)),
    ]
    again: list[Told] = [(3.0, "r1", called(9, 1, 2, 3)), (3.0, "r1", MusterJoined(epoch=9))]
    counts = counted(*apart, *again)
    assert (counts[Sometimes.TWO_CALLS], counts[Sometimes.TWO_CALLS_MET]) == (1, 1)
    assert not {Sometimes.TWO_CALLS, Sometimes.TWO_CALLS_MET} & set(counted(*apart[2:], *again))
    died = (2.5, WORLD, struck("kill", "r3"))
    assert Sometimes.TWO_CALLS_MET not in counted(*apart, died, *again)


def test_a_token_comes_back_while_its_robot_is_cut_from_another_not_from_the_router() -> None:
    off: list[Told] = [
        (
            0.1 * number,
            "r1",
            FaultInjected(fault="partition", rule="off", key="body/r1/odometry", number=number),
        )
        for number in range(21, 36)
    ]

    def lost(t_s: float, rule: str) -> Told:
        return (t_s, "r2", FaultInjected(fault="partition", rule=rule, key="link/r1/r2", number=3))

    assert counted(*off, lost(3.7, "cut"), lost(3.9, "cut"))[Sometimes.BACK_WHILE_CUT] == 1
    assert Sometimes.BACK_WHILE_CUT not in counted(*off, lost(3.7, "off"))
    assert Sometimes.BACK_WHILE_CUT not in counted(*off, lost(5.0, "cut"))
    assert Sometimes.BACK_WHILE_CUT not in counted(*off[:5], lost(2.7, "cut")), "it had kept its token"
    assert Sometimes.BACK_WHILE_CUT in counted(*off, (8.0, "r1", off[0][2]), lost(3.7, "cut"))


def test_a_clock_lags_for_as_long_as_there_is_odometry_that_its_robot_has_missed_since() -> None:
    strand = (0.0, "r1", formed(1, 1, 2, 3))
    missed: list[Told] = [
        (0.1 * number, "r1", FaultInjected(fault="drop", rule="d", key="body/r1/odometry", number=number))
        for number in (20, 21, 22)
    ]
    assert counted(strand, *missed, (2.35, WORLD, struck("kill", "r2")))[Sometimes.LAGGED_AT_DEATH] == 1
    assert Sometimes.LAGGED_AT_DEATH not in counted(strand, *missed, (2.45, WORLD, struck("kill", "r2")))
    assert Sometimes.LAGGED_AT_DEATH not in counted(strand, *missed, (2.35, WORLD, struck("kill", "r1")))


def test_orders_of_a_former_life_are_told_from_those_of_the_new_one_by_their_number() -> None:
    def refused(t_s: float, number: int) -> Told:
        return (t_s, WORLD, OrderRefused(robot=1, number=number, reason="order 1 is void"))

    lives: list[Told] = [
        (1.0, WORLD, accepted(1, 1)),
        (2.0, WORLD, struck("kill", "r1")),
        (2.0, WORLD, struck("start", "r1")),
    ]
    assert counted(*lives, refused(2.5, 2))[Sometimes.FORMER_ORDER_REFUSED] == 1
    assert Sometimes.FORMER_ORDER_REFUSED not in counted(*lives, refused(2.5, 21_001))
    assert counted(*lives, (2.5, WORLD, accepted(1, 1)))[Sometimes.FORMER_ORDER] == 1
    assert counted(*lives, refused(3.5, 21_001))[Sometimes.BEGAN_BLIND] == 1
    assert Sometimes.BEGAN_BLIND not in counted(*lives, refused(2.5, 21_001), refused(3.5, 21_002))


def test_who_is_killed_unseen_or_beside_one_that_has_just_been_restarted_is_counted() -> None:
    strand = (0.0, "r1", formed(1, 1, 2, 3))
    down = (1.0, WORLD, struck("kill", "world"))
    kill = (2.0, WORLD, struck("kill", "r3"))
    assert counted(strand, down, kill)[Sometimes.KILLED_UNSEEN] == 1
    assert Sometimes.KILLED_UNSEEN not in counted(strand, down, (1.5, WORLD, struck("start", "world")), kill)
    again = (1.0, WORLD, struck("start", "r2"))
    assert counted(strand, again, kill)[Sometimes.KILLED_BESIDE_RESTARTED] == 1
    assert Sometimes.KILLED_BESIDE_RESTARTED not in counted(strand, (1.0, WORLD, struck("start", "r1")), kill)
    killed, later = (1.0, WORLD, struck("kill", "r2")), (3.0, WORLD, struck("start", "r2"))
    assert counted(strand, killed, kill, later)[Sometimes.KILLED_BESIDE_RESTARTED] == 1
