"""P1, P3 and the part of P4 about entries: what robots may record of their strand; see `invariants`."""

from collections.abc import Iterator
from itertools import pairwise

from protocol.timeline import (
    AuthorityGranted,
    LeaderSucceeded,
    MusterJoined,
    PromiseBroken,
    RobotStarted,
    StepPlanned,
    StrandFormed,
    StrandHealed,
)
from world.judge.history import History


def judge_told(history: History, robot: int) -> Iterator[tuple[float, PromiseBroken]]:
    """The unlawful entries of one robot, each with its time."""
    joined: int | None = None  # the newest muster of this process
    for t_s, record in history.told[robot]:
        match record:
            case RobotStarted():
                joined = None
            case MusterJoined(epoch=epoch):
                joined = epoch
                if robot not in history.members.get(epoch, (robot,)):
                    yield t_s, broken("P4", robot, f"joined muster {epoch}, to which it was not called")
            case StrandFormed():
                yield from ((t_s, each) for each in _judge_strand(history, robot, record, joined))
            case StepPlanned(epoch=epoch) | LeaderSucceeded(epoch=epoch) | StrandHealed(epoch=epoch):
                first = history.strands[epoch][1].order[0] if epoch in history.strands else robot
                if first != robot:
                    does = "plans steps" if isinstance(record, StepPlanned) else "says that it leads"
                    yield t_s, broken("P1", robot, f"{does} in epoch {epoch}, which another leads", first)
            case AuthorityGranted():
                if (breach := _judge_grant(history, robot, record)) is not None:
                    yield t_s, breach
            case _:
                pass  # irrelevant for strands


def broken(invariant: str, robot: int, why: str, other: int | None = None) -> PromiseBroken:
    """A violation without a length."""
    return PromiseBroken(invariant=invariant, robot=robot, other=other, why=why)


def _judge_strand(
    history: History, robot: int, strand: StrandFormed, joined: int | None
) -> Iterator[PromiseBroken]:
    epoch, order = strand.epoch, strand.order
    before, first = history.strands[epoch]
    if order != first.order:
        why = f"took its place in epoch {epoch} in the order {order}, another in {first.order}"
        yield broken("P1", robot, why, before)
    if len(set(order)) < len(order) or robot not in order:
        yield broken(
            "P3", robot, f"took its place in epoch {epoch} in {order}, which is no strand of its own"
        )
    strangers = set(order) - set(history.members.get(joined, order)) if joined is not None else set()
    if strangers:
        named = ", ".join(map(str, sorted(strangers)))
        yield broken(
            "P4", robot, f"is in a strand with {named}, not called to muster {joined}", min(strangers)
        )


def _judge_grant(history: History, robot: int, grant: AuthorityGranted) -> PromiseBroken | None:
    if grant.epoch not in history.strands:
        return broken("P3", robot, f"grants ground in epoch {grant.epoch}, which has no strand", grant.to)
    order = history.strands[grant.epoch][1].order
    if (robot, grant.to) in pairwise(order):
        return None
    return broken(
        "P3", robot, f"grants ground in epoch {grant.epoch} to a robot not directly behind it", grant.to
    )
