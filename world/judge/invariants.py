"""The invariants of every run besides S1 and S2, under any loss, delay, damage, kill or freeze.

They are judged from the timeline alone, in one place for live runs, rehearsals and logs.
S3: `world.judge.motion` and, while robots join, `world.judge.authority`.
F1 to F6: the rules of fences (docs/strand.md), as far as a timeline shows them. `world.judge.fences` judges
    the fences, `formations` what the coordinator made, `authority` the orders, and `motion` the bodies. Here:
    F2: no robot plans or grants in an epoch that is not in force yet.
    F5: ground is granted only under ALL, by a member to the robot directly behind it, and never taken back.
P1: only the first robot of a formation leads it: only that robot plans steps and records that it leads.
P2: epochs never decrease in the entries of one process of a robot.
P3: there is no ring, and each robot has one robot ahead: `world.judge.formations`.
P4: stale or forged messages have no effect: no robot joins or leaves a view before its epoch is in force.
P5: queues are bounded and long enough: no inbox or outbox overflows, and entry numbers have no gaps.
P6: no core fails.
`world.judge.truth` holds what robots record against true poses: S4, A1, A2, and for who may record it P1, P7.
"""

from collections import defaultdict
from collections.abc import Iterator, Sequence
from operator import itemgetter

from protocol.timeline import (
    AuthorityGranted,
    LeaderSucceeded,
    PromiseBroken,
    RobotFailed,
    RobotStarted,
    StepPlanned,
    StrandHealed,
    StrandJoined,
    TrafficCounted,
    ViewJoined,
    ViewLeft,
)
from world.judge.authority import Authority
from world.judge.evidence import ROUNDING_M, Evidence, Told
from world.judge.fences import ROUNDING_S, judge_fences
from world.judge.formations import Dated, broken, judge_formations, judge_rank
from world.judge.motion import Tolerance, breach_of, judge_motion

ARRIVAL = ("A1", "A2")
"""What an arrival must keep to be one."""

INVARIANTS = (
    *("S1", "S2", "S3", "S4"),
    *("F1", "F2", "F3", "F4", "F5", "F6"),
    *("P1", "P2", "P3", "P4", "P5", "P6", "P7"),
    *ARRIVAL,
)
"""All invariants of a run, in the order of the verdict."""


def judge_invariants(evidence: Evidence, tolerance: Tolerance, *, followers_sense: bool) -> list[Dated]:
    """Every violation of S3, F1 to F6 and P1 to P6 with its time; without a length, the same counts once.

    Args:
        evidence: all of the run.
        tolerance: the allowed deviation of bodies.
        followers_sense: whether the law has followers check their way.
    """
    breaches: list[Dated] = [
        *judge_fences(evidence.fences),
        *judge_formations(evidence),
        *Authority(evidence, tolerance, followers_sense=followers_sense).judge(),
        *judge_motion(evidence, tolerance),
    ]
    for t_s, robot, n in evidence.holes:
        breaches.append((t_s, broken("P5", robot, f"its entries go on with number {n}")))
    for robot, told in sorted(evidence.told.items()):
        breaches += _judge_leading(evidence, robot, told)
        breaches += _judge_grants(evidence, robot, told)
        breaches += _judge_epochs(robot, told)
        breaches += _judge_fenced(evidence, robot, told)
        breaches += _judge_process(robot, told)
    first: dict[tuple[PromiseBroken, float | None], Dated] = {}
    for t_s, breach in sorted(breaches, key=itemgetter(0)):
        # Two motions that miss by the same length are two violations.
        first.setdefault((breach, None if breach.measured_m is None else t_s), (t_s, breach))
    return list(first.values())


def _judge_leading(evidence: Evidence, robot: int, told: Sequence[tuple[float, Told]]) -> Iterator[Dated]:
    """P1."""
    for t_s, record in told:
        match record:
            case StepPlanned(joins=True):
                continue
            case StepPlanned(epoch=epoch) | LeaderSucceeded(epoch=epoch) | StrandHealed(epoch=epoch):
                formed = evidence.formed.get(epoch)
                first = robot if formed is None else formed.strand.order[0]
                if first != robot:
                    does = "plans steps" if isinstance(record, StepPlanned) else "says that it leads"
                    yield t_s, broken("P1", robot, f"{does} in epoch {epoch}, which another leads", first)
            case _:
                pass  # says nothing about who leads


def _judge_grants(evidence: Evidence, robot: int, told: Sequence[tuple[float, Told]]) -> Iterator[Dated]:
    """F5 for grants."""
    granted_m: defaultdict[tuple[int, int], float] = defaultdict(float)
    for t_s, grant in told:
        if not isinstance(grant, AuthorityGranted):
            continue
        in_epoch = f"in epoch {grant.epoch}"
        driven, formed = evidence.fences.all_of(grant.epoch), evidence.formed.get(grant.epoch)
        if driven is None or evidence.fences.times_s[driven] > t_s + ROUNDING_S:
            yield t_s, broken("F5", robot, f"grants ground {in_epoch} before its strand may drive", grant.to)
        elif formed is not None and not formed.is_behind(grant.to, robot):
            why = f"grants ground {in_epoch} to a robot that is not directly behind it"
            yield t_s, broken("F5", robot, why, grant.to)
        link = grant.to, grant.epoch
        if grant.authority_m < granted_m[link] - ROUNDING_M:
            why = f"takes back what it has granted robot {grant.to}"
            yield t_s, breach_of("F5", robot, grant.authority_m, granted_m[link], why, other=grant.to)
        granted_m[link] = max(granted_m[link], grant.authority_m)


def _judge_epochs(robot: int, told: Sequence[tuple[float, Told]]) -> Iterator[Dated]:
    """P2."""
    newest = -1
    for t_s, record in told:
        match record:
            case RobotStarted():
                newest = -1
            case (
                ViewJoined(epoch=epoch)
                | ViewLeft(epoch=epoch)
                | StrandJoined(epoch=epoch)
                | StepPlanned(epoch=epoch)
                | AuthorityGranted(epoch=epoch)
            ):
                if epoch < newest:
                    yield t_s, broken("P2", robot, f"goes from epoch {newest} to {epoch}")
                newest = max(newest, epoch)
            case _:
                pass  # has no epoch, or tells of a strand as a whole


def _judge_fenced(evidence: Evidence, robot: int, told: Sequence[tuple[float, Told]]) -> Iterator[Dated]:
    """F2, P4, and F4 for ranks."""
    for t_s, record in told:
        match record:
            case StepPlanned(epoch=epoch) | AuthorityGranted(epoch=epoch):
                if evidence.fences.begun_s(epoch) > t_s + ROUNDING_S:
                    yield t_s, broken("F2", robot, f"plans or grants in epoch {epoch}, which is not in force")
            case ViewJoined(epoch=epoch) | ViewLeft(epoch=epoch):
                if evidence.fences.begun_s(epoch) > t_s + ROUNDING_S:
                    why = f"joins or leaves the view of epoch {epoch}, which is not in force"
                    yield t_s, broken("P4", robot, why)
            case StrandJoined() as joined:
                if (breach := judge_rank(evidence, robot, t_s, joined)) is not None:
                    yield t_s, breach
            case _:
                pass  # irrelevant for fences


def _judge_process(robot: int, told: Sequence[tuple[float, Told]]) -> Iterator[Dated]:
    """P5 and P6."""
    for t_s, record in told:
        match record:
            case TrafficCounted(overflowed=overflowed, unrecorded=unrecorded) if overflowed or unrecorded:
                why = f"dropped {overflowed} arrivals and {unrecorded} entries: its queues were full"
                yield t_s, broken("P5", robot, why)
            case RobotFailed(reason=reason):
                yield t_s, broken("P6", robot, reason)
            case _:
                pass  # no violation
