"""P1 to P6: each constructed violation is found, and real fleets violate none."""

import pytest

from agents.commands import Command
from agents.events import Event, OdometryHeard
from agents.robot import Robot
from clew.rehearsal.rehearsal import Rehearsal
from protocol.frames import Point
from protocol.root import ROOT
from protocol.timeline import (
    AuthorityGranted,
    Entry,
    LeaderSucceeded,
    MusterCalled,
    MusterJoined,
    OrderAccepted,
    PoseSampled,
    Record,
    RobotFailed,
    RobotStarted,
    StrandFormed,
    StrandHealed,
    TrafficCounted,
)
from world.judge.evidence import Evidence
from world.judge.invariants import judge_invariants
from world.judge.judgement import judge
from world.scenario.scenario import load

PLANS = ROOT / "launch" / "faults"
MISSION = load("paper", robots=4).mission()
MUSTER = 10_010_000  # the first epoch that robot 1 calls: protocol/epochs.py
STRAND = MUSTER + 1

Said = tuple[float, str, Record]


def strand(epoch: int, *order: int) -> StrandFormed:
    return StrandFormed(epoch=epoch, sensed=False, order=order, path_length_m=1.0)


def grant(to: int, epoch: int) -> AuthorityGranted:
    return AuthorityGranted(to=to, epoch=epoch, authority_m=1.0)


def order(number: int, epoch: int, *, to_m: float | None = 1.0) -> OrderAccepted:
    target = None if to_m is None else Point(x_m=to_m, y_m=0.0)
    return OrderAccepted(
        robot=2, number=number, epoch=epoch, step=0, x_m=0.0, y_m=0.0, target=target, reach_m=1.0
    )


def pose(x_m: float) -> PoseSampled:
    return PoseSampled(robot=2, x_m=x_m, y_m=0.0, heading_rad=0.0)


def counted(*, overflowed: int = 0, unrecorded: int = 0) -> TrafficCounted:
    return TrafficCounted(
        sent={}, received={}, newest={}, refused={}, overflowed=overflowed, unrecorded=unrecorded
    )


def broken(*said: Said) -> list[str]:
    """The names of the invariants that a timeline violates, once per violation."""
    evidence, counts = Evidence(), dict[str, int]()
    for t_s, source, record in said:
        counts[source] = 1 if isinstance(record, RobotStarted) else counts.get(source, 0) + 1
        evidence.hear(source, Entry(n=counts[source], t_s=t_s, hlc="", record=record))
    return [breach.invariant for _, breach in judge_invariants(evidence, MISSION)]


HEALED: tuple[Said, ...] = (
    (0.0, "r1", strand(1, 1, 2, 3)),
    (0.1, "r2", strand(1, 1, 2, 3)),
    (0.1, "r3", strand(1, 1, 2, 3)),
    (0.2, "r1", grant(2, 1)),
    (0.2, "world", order(1, 1)),
    (3.0, "r2", MusterCalled(epoch=MUSTER, members=(2, 3), why="robot 1 is lost")),
    (3.0, "r2", MusterJoined(epoch=MUSTER)),
    (3.1, "r3", MusterJoined(epoch=MUSTER)),
    (3.9, "world", order(2, 1)),  # a late order, still valid
    (6.0, "r2", strand(STRAND, 2, 3)),
    (6.0, "r2", LeaderSucceeded(epoch=STRAND, before=1)),
    (6.1, "r3", strand(STRAND, 2, 3)),
    (6.2, "r2", StrandHealed(epoch=STRAND, members=(2, 3))),
    (6.3, "r2", grant(3, STRAND)),
    (6.4, "world", order(3, STRAND)),
    (9.0, "r2", counted()),
)
"""A leader is lost, and the strand continues without it."""


def test_a_strand_that_heals_violates_nothing() -> None:
    assert broken(*HEALED) == []


BREACHES: tuple[tuple[str, tuple[Said, ...]], ...] = (
    ("P1", ((6.5, "r3", strand(STRAND + 1, 2, 3)), (6.5, "r2", strand(STRAND + 1, 3, 2)))),
    ("P1", ((6.5, "r3", LeaderSucceeded(epoch=STRAND, before=2)),)),
    ("P1", ((6.5, "r3", StrandHealed(epoch=STRAND, members=(2, 3))),)),
    ("P2", ((6.5, "r1", strand(1, 1, 2, 3)),)),
    ("P2", ((6.5, "r3", MusterJoined(epoch=MUSTER)),)),
    ("P2", ((6.5, "r1", strand(2, 1, 2, 3)), (6.5, "r1", grant(2, 1)))),
    ("P2", ((6.5, "world", order(4, STRAND - 1)),)),
    ("P3", ((6.5, "r3", grant(2, STRAND)),)),
    ("P3", ((6.5, "r2", grant(4, STRAND)),)),
    ("P3", ((6.5, "r2", grant(3, STRAND + 5)),)),
    ("P3", ((6.5, "r2", strand(STRAND + 1, 2, 3, 2)),)),
    ("P4", ((6.5, "r2", strand(STRAND + 1, 2, 3, 1)),)),
    ("P4", ((6.5, "r4", MusterJoined(epoch=MUSTER)),)),
    ("P5", ((9.1, "r3", counted(overflowed=1)),)),
    ("P5", ((9.1, "r3", counted(unrecorded=1)),)),
    ("P6", ((9.1, "r3", RobotFailed(reason="AssertionError: nobody ahead")),)),
)


@pytest.mark.parametrize(("invariant", "said"), BREACHES)
def test_unlawful_entries_are_found(invariant: str, said: tuple[Said, ...]) -> None:
    assert set(broken(*HEALED, *said)) == {invariant}


def test_a_body_that_accepts_an_expired_order_from_before_its_robot_joined_is_found() -> None:
    late = (4.1, "world", order(2, 1))
    assert broken(*HEALED[:8], late) == ["P4"]
    assert broken(*HEALED[:8], (4.1, "world", order(2, 1, to_m=None))) == [], (
        "to stand still is always lawful"
    )


@pytest.mark.parametrize(("until_s", "found"), [(4.9, []), (5.1, ["P4"])])
def test_a_body_that_moves_after_the_lease_of_its_epoch_has_expired_is_found(
    until_s: float, found: list[str]
) -> None:
    moves: tuple[Said, ...] = (
        (until_s, "world", pose(0.0)),
        (until_s + 0.1, "world", pose(0.05)),
        (until_s + 0.2, "world", pose(0.1)),
    )
    assert broken(*HEALED[:8], *moves) == found


def test_a_missing_entry_is_found_and_a_restarted_process_counts_from_one() -> None:
    evidence = Evidence()
    for n in (1, 2, 1, 2, 4):
        evidence.hear("r2", Entry(n=n, t_s=1.0, hlc="", record=RobotStarted(pid=1)))
    assert [breach.why for _, breach in judge_invariants(evidence, MISSION)] == [
        "its entries go on with number 4"
    ]


def test_a_restarted_robot_may_begin_with_the_first_epoch() -> None:
    again = (6.5, "r2", RobotStarted(pid=7))
    assert broken(*HEALED, again, (6.6, "r2", strand(1, 1, 2, 3))) == []


def test_identical_violations_count_once() -> None:
    wrong = grant(4, STRAND)
    assert broken(*HEALED, (6.5, "r2", wrong), (6.6, "r2", wrong)) == ["P3"]


def test_a_failed_core_is_recorded_its_process_ends_and_the_others_continue(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    whole = Robot.handle

    def planted(self: Robot, event: Event, now_s: float) -> list[Command]:
        if isinstance(event, OdometryHeard) and now_s > 4.0 and self._robot == 3:
            raise KeyError("planted")
        return whole(self, event, now_s)

    monkeypatch.setattr(Robot, "handle", planted)
    rehearsal = Rehearsal(load("grove"), 1).run()
    breaches = judge(rehearsal.world.scenario, rehearsal.entries).breaches
    assert [(breach.broken.invariant, breach.broken.robot) for breach in breaches] == [("P6", 3)]
    assert breaches[0].broken.why.startswith("KeyError: 'planted' (test_invariants.py:")
    assert rehearsal.world.tally.arrived == {1, 2, 4, 5}
