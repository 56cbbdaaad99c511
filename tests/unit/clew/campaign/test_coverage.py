from clew.campaign.coverage import count_coverage, uncovered
from clew.campaign.coverage_names import Situation
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
    return count_coverage(entries, PLAN)


def struck(fault: str, process: str, rule: str = "kill-1") -> FaultInjected:
    return FaultInjected(fault=fault, rule=rule, process=process)


def formed(epoch: int, *order: int) -> StrandFormed:
    return StrandFormed(epoch=epoch, sensed=False, order=order, path_length_m=1.0)


def accepted(robot: int, epoch: int) -> OrderAccepted:
    return OrderAccepted(
        robot=robot, number=1, epoch=epoch, step=0, x_m=0.0, y_m=0.0, target=HERE, reach_m=0.0
    )


def test_a_leader_killed_between_call_and_healing_counts_as_killed_in_a_succession() -> None:
    before: list[Told] = [
        (0.0, "r1", formed(1, 1, 2, 3)),
        (1.0, "r2", MusterCalled(epoch=5, members=(2, 3), why="")),
    ]
    after: list[Told] = [(1.0, "r2", MusterJoined(epoch=5)), (1.2, "r2", formed(6, 2, 3))]
    healed: list[Told] = [(1.3, "r2", StrandHealed(epoch=6, members=(2, 3)))]
    kill = (2.0, WORLD, struck("kill", "r2"))
    assert counted(*before, *after, kill)[Situation.LEADER_KILLED_IN_SUCCESSION] == 1
    quiet = counted(*before, *after, *healed, kill)
    assert Situation.LEADER_KILLED_IN_SUCCESSION not in quiet
    assert quiet[Situation.LEADER_KILLED] == 1


def test_a_thawed_robot_that_orders_its_body_in_an_old_epoch_counts_as_a_zombie() -> None:
    told: list[Told] = [
        (0.0, "r1", formed(1, 1, 2, 3)),
        (1.0, WORLD, struck("freeze", "r1")),
        (3.0, "r2", formed(6, 2, 3)),
        (5.0, WORLD, struck("thaw", "r1")),
    ]
    assert counted(*told, (5.1, WORLD, accepted(1, 1)))[Situation.ZOMBIE_SPOKE] == 1
    joined = (5.05, "r1", MusterJoined(epoch=9))
    assert Situation.ZOMBIE_SPOKE not in counted(*told, joined, (5.1, WORLD, accepted(1, 9)))


def test_two_killed_at_once_count_only_if_they_are_neighbours() -> None:
    strand = (0.0, "r1", formed(1, 1, 2, 3))
    one = (1.0, WORLD, struck("kill", "r1"))
    assert Situation.TWO_NEIGHBOURS_KILLED in counted(strand, one, (1.0, WORLD, struck("kill", "r2")))
    assert Situation.TWO_NEIGHBOURS_KILLED not in counted(strand, one, (1.0, WORLD, struck("kill", "r3")))


def test_calls_cross_if_the_second_caller_has_not_joined_the_first() -> None:
    first = (1.0, "r1", MusterCalled(epoch=5, members=(1, 2), why=""))
    second = (1.1, "r2", MusterCalled(epoch=7, members=(1, 2), why=""))
    assert counted(first, second)[Situation.CALLS_CROSSED] == 1
    assert Situation.CALLS_CROSSED not in counted(first, (1.05, "r2", MusterJoined(epoch=5)), second)


def test_a_token_loss_is_false_if_its_process_suffered_no_fault() -> None:
    broken = (2.0, "r1", LinkBroken(neighbour=2, cause="token", silent_s=0.5))
    assert counted(broken)[Situation.FALSE_TOKEN_LOSS] == 1
    assert Situation.FALSE_TOKEN_LOSS not in counted((1.0, WORLD, struck("kill", "r2")), broken)


def test_the_other_situations_in_a_timeline_are_counted() -> None:
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
        Situation.KILLED_AFTER_PLAN,
        Situation.KILLED_IN_REVERSAL,
        Situation.ROUTER_LOST_IN_MUSTER,
        Situation.STALE_EPOCH_REFUSED,
        Situation.STALE_ORDER_REFUSED,
        Situation.RESTART_JOINED,
        Situation.CUT_WHILE_LINING_UP,
        Situation.LOST,
        Situation.LOST_IN_BURST,
    }
    assert Situation.DELAYED.value in uncovered(counts)
    assert Situation.LOST.value not in uncovered(counts)


def called(epoch: int, *members: int) -> MusterCalled:
    return MusterCalled(epoch=epoch, members=members, why="")


def test_two_calls_meet_when_a_robot_joins_the_call_of_a_robot_that_both_had_left_out() -> None:
    apart: list[Told] = [
        (1.0, "r3", called(5, 3)),
        (1.0, "r3", MusterJoined(epoch=5)),
        (2.0, "r1", called(7, 1, 2)),
        (2.0, "r1", MusterJoined(epoch=7)),
    ]
    again: list[Told] = [(3.0, "r1", called(9, 1, 2, 3)), (3.0, "r1", MusterJoined(epoch=9))]
    counts = counted(*apart, *again)
    assert (counts[Situation.TWO_CALLS], counts[Situation.TWO_CALLS_MET]) == (1, 1)
    assert not {Situation.TWO_CALLS, Situation.TWO_CALLS_MET} & set(counted(*apart[2:], *again))
    died = (2.5, WORLD, struck("kill", "r3"))
    assert Situation.TWO_CALLS_MET not in counted(*apart, died, *again)


def test_a_token_back_while_cut_counts_for_a_cut_from_a_robot_not_from_the_router() -> None:
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

    assert counted(*off, lost(3.7, "cut"), lost(3.9, "cut"))[Situation.BACK_WHILE_CUT] == 1
    assert Situation.BACK_WHILE_CUT not in counted(*off, lost(3.7, "off"))
    assert Situation.BACK_WHILE_CUT not in counted(*off, lost(5.0, "cut"))
    assert Situation.BACK_WHILE_CUT not in counted(*off[:5], lost(2.7, "cut")), (
        "the cut was too short to lose the token"
    )
    assert Situation.BACK_WHILE_CUT in counted(*off, (8.0, "r1", off[0][2]), lost(3.7, "cut"))


def test_a_clock_lags_until_the_first_odometry_after_the_missed_ones() -> None:
    strand = (0.0, "r1", formed(1, 1, 2, 3))
    missed: list[Told] = [
        (0.1 * number, "r1", FaultInjected(fault="drop", rule="d", key="body/r1/odometry", number=number))
        for number in (20, 21, 22)
    ]
    assert counted(strand, *missed, (2.35, WORLD, struck("kill", "r2")))[Situation.LAGGED_AT_DEATH] == 1
    assert Situation.LAGGED_AT_DEATH not in counted(strand, *missed, (2.45, WORLD, struck("kill", "r2")))
    assert Situation.LAGGED_AT_DEATH not in counted(strand, *missed, (2.35, WORLD, struck("kill", "r1")))


def test_the_number_of_an_order_tells_a_former_life_from_the_new_one() -> None:
    def refused(t_s: float, number: int) -> Told:
        return (t_s, WORLD, OrderRefused(robot=1, number=number, reason="order 1 is void"))

    lives: list[Told] = [
        (1.0, WORLD, accepted(1, 1)),
        (2.0, WORLD, struck("kill", "r1")),
        (2.0, WORLD, struck("start", "r1")),
    ]
    assert counted(*lives, refused(2.5, 2))[Situation.FORMER_ORDER_REFUSED] == 1
    assert Situation.FORMER_ORDER_REFUSED not in counted(*lives, refused(2.5, 21_001))
    assert counted(*lives, (2.5, WORLD, accepted(1, 1)))[Situation.FORMER_ORDER] == 1
    assert counted(*lives, refused(3.5, 21_001))[Situation.BEGAN_BLIND] == 1
    assert Situation.BEGAN_BLIND not in counted(*lives, refused(2.5, 21_001), refused(3.5, 21_002))


def test_a_kill_while_the_world_is_down_or_beside_a_restarted_robot_is_counted() -> None:
    strand = (0.0, "r1", formed(1, 1, 2, 3))
    down = (1.0, WORLD, struck("kill", "world"))
    kill = (2.0, WORLD, struck("kill", "r3"))
    assert counted(strand, down, kill)[Situation.KILLED_UNSEEN] == 1
    assert Situation.KILLED_UNSEEN not in counted(strand, down, (1.5, WORLD, struck("start", "world")), kill)
    again = (1.0, WORLD, struck("start", "r2"))
    assert counted(strand, again, kill)[Situation.KILLED_BESIDE_RESTARTED] == 1
    assert Situation.KILLED_BESIDE_RESTARTED not in counted(strand, (1.0, WORLD, struck("start", "r1")), kill)
    killed, later = (1.0, WORLD, struck("kill", "r2")), (3.0, WORLD, struck("start", "r2"))
    assert counted(strand, killed, kill, later)[Situation.KILLED_BESIDE_RESTARTED] == 1
