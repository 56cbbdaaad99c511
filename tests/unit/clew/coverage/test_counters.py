from clew.coverage.counters import count_coverage, uncovered
from clew.coverage.situations import Situation
from protocol.faults.plan import Plan
from protocol.faults.rules import Burst, Drop, Kill, Partition, StepPoint
from protocol.keys import WORLD
from protocol.timeline import (
    Entry,
    FaultInjected,
    LinkBroken,
    OrderRefused,
    Record,
    RobotRestarted,
    StrandHealed,
    StrandReversed,
    ViewJoined,
)
from tests.support.strands import ordered, strand

E, F = 10_001, 20_002
"""The epochs of two views."""
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


def refused(
    robot: int,
    *,
    fence: int = E,
    fence_turn: int = 1,
    number: int = 1,
    why: str = "",
) -> OrderRefused:
    return OrderRefused(
        robot=robot, number=number, epoch=E, turn=1, fence=fence, fence_turn=fence_turn, reason=why
    )


def drives(t_s: float, epoch: int, *order: int) -> list[Told]:
    """A view in which this strand forms, all at one time."""
    return [(t_s, source, record) for source, record in strand(epoch, *order)]


def test_an_order_of_a_robot_that_just_thawed_counts_as_a_zombie_if_its_epoch_is_over() -> None:
    told: list[Told] = [
        *drives(0.0, E, 1, 2, 3),
        (1.0, WORLD, struck("freeze", "r1")),
        *drives(3.0, F, 2, 3),
        (5.0, WORLD, struck("thaw", "r1")),
    ]
    spoke = (5.1, WORLD, refused(1, fence=F))
    counts = counted(*told, spoke)
    assert (counts[Situation.ZOMBIE_SPOKE], counts[Situation.STALE_EPOCH_REFUSED]) == (1, 1)
    joined = (5.05, "r1", ViewJoined(epoch=F))
    assert Situation.ZOMBIE_SPOKE not in counted(*told, joined, spoke)
    assert Situation.ZOMBIE_SPOKE not in counted(*told, (6.5, WORLD, refused(1, fence=F)))


def test_a_refused_order_is_of_an_older_epoch_or_turn_or_on_stale_odometry() -> None:
    assert counted((1.0, WORLD, refused(1, fence=F))) == {Situation.STALE_EPOCH_REFUSED: 1}
    assert counted((1.0, WORLD, refused(1, fence_turn=2))) == {Situation.STALE_TURN_REFUSED: 1}
    stale = refused(1, why="order 1 is void: its basis is 2 s old")
    assert counted((1.0, WORLD, stale)) == {Situation.STALE_ORDER_REFUSED: 1}


def test_two_killed_at_once_count_only_if_they_are_neighbours() -> None:
    one = (*drives(0.0, E, 1, 2, 3), (1.0, WORLD, struck("kill", "r1")))
    assert Situation.TWO_NEIGHBOURS_KILLED in counted(*one, (1.0, WORLD, struck("kill", "r2")))
    assert Situation.TWO_NEIGHBOURS_KILLED not in counted(*one, (1.0, WORLD, struck("kill", "r3")))


def test_a_token_loss_is_false_if_its_process_suffered_no_fault() -> None:
    broken = (2.0, "r1", LinkBroken(neighbour=2, cause="token", silent_s=0.5))
    assert counted(broken)[Situation.FALSE_TOKEN_LOSS] == 1
    assert Situation.FALSE_TOKEN_LOSS not in counted((1.0, WORLD, struck("kill", "r2")), broken)


def test_the_other_situations_in_a_timeline_are_counted() -> None:
    counts = counted(
        *drives(0.0, E, 1, 2),
        (0.5, "r1", StrandReversed(epoch=E, cut_m=0.0, end_m=1.0, back_by_m=1.0)),
        (1.0, WORLD, struck("kill", "r1", "at")),
        (1.1, WORLD, struck("kill", "r2")),
        (1.2, "r3", ViewJoined(epoch=F)),
        (3.0, WORLD, RobotRestarted(robot=1)),
        (3.6, "r2", FaultInjected(fault="drop", rule="bursts", key="link/1/2", number=3)),
        *drives(4.0, F, 4, 1),
        (4.1, "r4", StrandHealed(epoch=F, robots=2)),
    )
    assert set(counts) >= {
        Situation.KILLED_AFTER_PLAN,
        Situation.KILLED_IN_REVERSAL,
        Situation.LEADER_KILLED,
        Situation.TAIL_KILLED,
        Situation.RESTART_JOINED,
        Situation.SPLIT_HELD,
        Situation.LOST,
        Situation.LOST_IN_BURST,
    }
    assert Situation.DELAYED.value in uncovered(counts)
    assert Situation.LOST.value not in uncovered(counts)


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
    told = drives(0.0, E, 1, 2, 3)
    missed: list[Told] = [
        (0.1 * number, "r1", FaultInjected(fault="drop", rule="d", key="body/r1/odometry", number=number))
        for number in (20, 21, 22)
    ]
    assert counted(*told, *missed, (2.35, WORLD, struck("kill", "r2")))[Situation.LAGGED_AT_DEATH] == 1
    assert Situation.LAGGED_AT_DEATH not in counted(*told, *missed, (2.45, WORLD, struck("kill", "r2")))
    assert Situation.LAGGED_AT_DEATH not in counted(*told, *missed, (2.35, WORLD, struck("kill", "r1")))


def test_the_number_of_an_order_tells_a_former_life_from_the_new_one() -> None:
    def late(t_s: float, number: int) -> Told:
        return (t_s, WORLD, refused(1, number=number))

    lives: list[Told] = [
        (1.0, WORLD, ordered(1, epoch=E)),
        (2.0, WORLD, struck("kill", "r1")),
        (2.0, WORLD, struck("start", "r1")),
    ]
    assert counted(*lives, late(2.5, 2))[Situation.FORMER_ORDER_REFUSED] == 1
    assert Situation.FORMER_ORDER_REFUSED not in counted(*lives, late(2.5, 21_001))
    assert counted(*lives, (2.5, WORLD, ordered(1, epoch=E)))[Situation.FORMER_ORDER] == 1
    assert counted(*lives, late(3.5, 21_001))[Situation.BEGAN_BLIND] == 1
    assert Situation.BEGAN_BLIND not in counted(*lives, late(2.5, 21_001), late(3.5, 21_002))


def test_a_kill_while_the_world_is_down_or_beside_a_restarted_robot_is_counted() -> None:
    told = drives(0.0, E, 1, 2, 3)
    down = (1.0, WORLD, struck("kill", "world"))
    kill = (2.0, WORLD, struck("kill", "r3"))
    assert counted(*told, down, kill)[Situation.KILLED_UNSEEN] == 1
    assert Situation.KILLED_UNSEEN not in counted(*told, down, (1.5, WORLD, struck("start", "world")), kill)
    again = (1.0, WORLD, struck("start", "r2"))
    assert counted(*told, again, kill)[Situation.KILLED_BESIDE_RESTARTED] == 1
    assert Situation.KILLED_BESIDE_RESTARTED not in counted(*told, (1.0, WORLD, struck("start", "r1")), kill)
    killed, later = (1.0, WORLD, struck("kill", "r2")), (3.0, WORLD, struck("start", "r2"))
    assert counted(*told, killed, kill, later)[Situation.KILLED_BESIDE_RESTARTED] == 1
