"""What is asked after every step, from the true state of the world: S1, S2, F1 to F4.

S1, S2: the world's own monitor, in every tick.
S2 is also judged as soon as an order is accepted: the ground that bodies are ordered to drive over keeps the
    separation from all other hulls, and from the ground that other bodies are ordered to drive over. So no
    order may rest on a scan, a place or a grant that is not true any more; F5 and F6 prevent such orders.
F1: a body moves only by an order that bears exactly the fence, from a robot and life that the fence names.
F2: a robot orders motion only under the fence that its newest odometry has told, where that names it.
F3: the fence goes on by the next turn of its coordinator, or to the next generation, where nobody may move.
    Before ALL it names one robot at most, and ALL is the last.
F4: an epoch has one formation. When its ALL is taken, all members stand where it says. Under ALL only they
    drive, in the lives that it names.
F6 (a): what a robot has seen last when it plans a step was taken under the fence that its odometry tells.

Nothing here uses the code that keeps the rules: a bug there cannot hide itself.
"""

import math
from collections.abc import Iterator, Sequence
from itertools import combinations

import numpy as np

from clew.explore.explorable import Breach
from protocol.arrays import segments_apart
from protocol.fence import Fence, May
from protocol.frames import Pose
from protocol.path import Path
from protocol.timeline import OrderAccepted, PromiseBroken, Record, StrandFormed
from protocol.wire.messages import Drive, Scan
from protocol.wire.view import Formation
from world.core import World

ROUNDING_M = 1e-6  # of places that went through sums of metres


def judge_world(world: World, before: Fence, notes: Sequence[Record], put_by: int) -> list[tuple[int, Drive]]:
    """Judge a step of the world; returns the orders to move that bodies have accepted in it.

    Args:
        world: the world after the step.
        before: the fence before it.
        notes: what the world has recorded.
        put_by: whose message the world has heard; 0: nobody's.

    Raises:
        Breach: a promise is broken.
    """
    for note in notes:
        if isinstance(note, PromiseBroken):
            raise Breach(note.invariant, f"robot {note.robot}: {note.why} {note.measured_m}")
    fence = world.arena.fence
    if fence != before:
        judge_change(before, fence, put_by)
    _judge_orders(world, fence)
    ordered = list(_accepted(world, notes))
    if ordered:  # what is left of a course is a part of it
        _judge_ground(world)
    return ordered


def judge_change(before: Fence, after: Fence, put_by: int) -> None:
    """F3, for a change of the fence that this robot has put; 0: nobody, or the operator."""
    old, new = before.epoch, after.epoch
    if new != old:
        next_generation = new.generation == old.generation + 1
        tie = new.generation == old.generation and new.robot > old.robot and before.turn == 0
        stands = after.turn == 0 and after.may in {May.NOBODY, May.STOPPED}
        if not (stands and (next_generation or (tie and before.may is May.NOBODY))):
            raise Breach("F3", f"{_said(before)} is followed by {_said(after)}")
        if before.may is May.STOPPED and put_by != 0:
            raise Breach("F3", f"robot {put_by} ends the stop of {_said(before)}")
        return
    follows = after.turn == before.turn + 1 and before.may is not May.ALL and put_by == new.robot != 0
    one = after.may is not May.ONE or after.robot != 0
    if not follows or after.may is May.STOPPED or not one:
        raise Breach("F3", f"{_said(before)} is followed by {_said(after)}, put by robot {put_by}")


def _judge_orders(world: World, fence: Fence) -> None:
    """F1, for every body that moves now."""
    for body, order in enumerate(world.bodies.orders):
        if not world.bodies.is_moving(body):
            continue
        robot = body + 1
        if order is None or order.target is None:
            raise Breach("F1", f"body {robot} moves without an order")
        bearing = order.bearing
        if bearing.epoch != fence.epoch or bearing.turn != fence.turn:
            raise Breach("F1", f"body {robot} moves by an order of {bearing.epoch}, turn {bearing.turn}")
        _judge_named("F1", robot, bearing.life, fence)


def _judge_named(promise: str, robot: int, life: int, fence: Fence) -> None:
    named = fence.may is May.ALL or (fence.may is May.ONE and fence.robot == robot and fence.life == life)
    if not named:
        raise Breach(promise, f"robot {robot} in life {life:x} drives under {_said(fence)}")


def _judge_ground(world: World) -> None:
    """S2 of ordered ground, for all pairs of bodies of which at least one moves."""
    bodies, fleet = world.bodies, world.scenario.fleet
    moving = bodies.moving
    if not moving.any():
        return
    keep_m = 2 * fleet.robot_radius_m + fleet.separation_m - world.scenario.law.mu0_m - ROUNDING_M
    starts_m = bodies.place_m
    ends_m = np.where(moving[:, None], bodies.courses_m[:, 2:], starts_m)
    pairs = [pair for pair in combinations(range(len(starts_m)), 2) if moving[list(pair)].any()]
    first, second = np.array(pairs).T
    apart_m = segments_apart(starts_m[first], ends_m[first], starts_m[second], ends_m[second])
    nearest = int(apart_m.argmin())
    if apart_m[nearest] < keep_m:
        one, other = (each + 1 for each in pairs[nearest])
        near_m = float(apart_m[nearest])
        why = f"robots {one} and {other} are ordered to come within {near_m:.3f} m, not {keep_m:.3f} m"
        raise Breach("S2", why)


def _accepted(world: World, notes: Sequence[Record]) -> Iterator[tuple[int, Drive]]:
    for note in notes:
        if isinstance(note, OrderAccepted) and note.target is not None:
            order = world.bodies.orders[note.robot - 1]
            assert order is not None, "accepted just now"
            yield note.robot, order


def judge_order(robot: int, life: int, order: Drive, told: Fence | None) -> None:
    """F2, for an order to move that a robot gives."""
    bearing = order.bearing
    if told is None or (bearing.epoch, bearing.turn) != (told.epoch, told.turn):
        raise Breach(
            "F2", f"robot {robot} orders motion under {bearing}, its odometry has told {told and _said(told)}"
        )
    if bearing.life != life:
        raise Breach("F2", f"robot {robot} orders motion in life {bearing.life:x}, its own is {life:x}")
    _judge_named("F2", robot, life, told)


def judge_plan(robot: int, seen: Scan | None, told: Fence | None) -> None:
    """F6 (a), for a robot that plans a step: what it has seen last."""
    if seen is None or told is None:
        raise Breach("F6", f"robot {robot} plans a step and has seen nothing")
    if (seen.fence.epoch, seen.fence.turn) != (told.epoch, told.turn):
        raise Breach(
            "F6",
            f"robot {robot} plans under {_said(told)} with a scan that was taken under {_said(seen.fence)}",
        )


def judge_piece(piece: Formation, member: int, formed: StrandFormed | None) -> None:
    """F4: what a member is told is the one formation of its epoch."""
    if formed is None:
        raise Breach("F4", f"robot {member} is told a formation that nobody has noted")
    rank = formed.order.index(member) if member in formed.order else -1
    told = (piece.turn, piece.rank, piece.members, piece.vertices)
    noted = (formed.turn, rank, len(formed.order), len(formed.laid))
    laid = formed.laid[piece.first : piece.first + len(piece.path)]
    same = told == noted and f"{piece.life:x}" == formed.lives[rank] and piece.s_m == formed.places_m[rank]
    if not same or any((a.x_m, a.y_m) != (b.x_m, b.y_m) for a, b in zip(laid, piece.path, strict=True)):
        raise Breach("F4", f"two formations in one epoch: robot {member} is told {piece}, noted was {formed}")


def judge_places(fence: Fence, formed: StrandFormed | None, poses: Sequence[Pose], mu0_m: float) -> None:
    """F4: all members stand where the formation says when its ALL is taken."""
    if formed is None or (formed.turn, len(formed.order)) != (fence.turn, fence.members):
        raise Breach("F4", f"{_said(fence)} for {fence.members} members, formed is {formed}")
    path = Path(formed.laid)
    for member, at_m in zip(formed.order, formed.places_m, strict=True):
        true, told = poses[member - 1], path.at(at_m)
        off_m = math.hypot(true.x_m - told.x_m, true.y_m - told.y_m)
        if off_m > mu0_m:
            raise Breach("F4", f"robot {member} stands {off_m:.3f} m from its place in the formation")


def judge_member(robot: int, order: Drive, formed: StrandFormed | None) -> None:
    """F4: only members drive under ALL, in the lives that the formation names."""
    life = f"{order.bearing.life:x}"
    if formed is None or (robot, life) not in zip(formed.order, formed.lives, strict=True):
        raise Breach("F4", f"robot {robot} drives in life {life}, formed is {formed}")


def _said(fence: Fence) -> str:
    who = f" {fence.robot}" if fence.may is May.ONE else ""
    return f"epoch {fence.epoch.generation}.{fence.epoch.robot} turn {fence.turn} ({fence.may}{who})"
