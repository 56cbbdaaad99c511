"""The sentence for each kind of entry: the only place that words entries for users.

Rule 1: the sentence of a kind is a template over its fields, or a function where a template is not enough.
Rule 2: robots are written as `r3`; `by` is the source of the entry.
"""

from collections.abc import Callable
from typing import Any

from protocol.fence import Cause, May
from protocol.keys import robot_name
from protocol.timeline import (
    FaultInjected,
    FenceChanged,
    LeaderSucceeded,
    LinkBroken,
    OrderAccepted,
    Record,
    RobotStranded,
    SegmentChecked,
    StepFinished,
    StepPlanned,
    StrandFormed,
    TrafficCounted,
    kind_of,
)
from protocol.timeline.invariants import named

NAMED_MAX = 20  # robots of a strand, on a line of a terminal; the entry itself names all


def sentence(source: str, record: Record) -> str:
    """The sentence for an entry of this source, in plain English."""
    said = SENTENCES[kind_of(record)]
    return said.format(by=source, it=record) if isinstance(said, str) else said(source, record)


def _order(_: str, order: OrderAccepted) -> str:
    target = order.target
    does = "stand still" if target is None else f"drive to ({target.x_m:.2f}, {target.y_m:.2f})"
    return f"the body of {robot_name(order.robot)} accepts order {order.number}: {does}"


def _step(by: str, plan: StepPlanned) -> str:
    if plan.joins:
        return f"{by} goes {plan.length_m:.3f} m towards its place"
    promised_m = plan.promised_clearance_m
    promises = "" if promised_m is None else f", promises {promised_m:.3f} m"
    return f"{by} plans step {plan.step}: {plan.length_m:.3f} m{promises}"


def _step_end(_: str, end: StepFinished) -> str:
    kept = "" if end.clearance_m is None else f", {end.clearance_m:.3f} m clear"
    return f"{robot_name(end.robot)} finishes step {end.step}{kept}"


def _segment(by: str, checked: SegmentChecked) -> str:
    found = "clear" if checked.clear else "not clear"
    return f"{by} finds its next segment {found}, by {checked.clearance_m:.3f} m"


def _strand(_: str, formed: StrandFormed) -> str:
    order = [*map(robot_name, formed.order)]
    if len(order) > NAMED_MAX:
        return f"strand formed: {' < '.join([*order[:3], '...', order[-1]])} ({len(order)} robots)"
    return f"strand formed: {' < '.join(order)}"


CAUSES = {
    Cause.START: "the run begins",
    Cause.NEIGHBOUR_LOST: "a neighbour is lost",
    Cause.BLOCKED: "a way stays blocked",
    Cause.DEAD_END: "the way is a dead end",
    Cause.NO_WAY: "the leader knows no way on",
    Cause.PLEA: "a robot asks to be let in",
    Cause.COORDINATOR_LOST: "the coordinator is lost",
    Cause.MISFIT: "a robot does not stand at its place",
    Cause.OUTSIDERS: "more robots are left out than are in the strand",
    Cause.OPERATOR: "the operator ends the stop",
    Cause.WORLD_RESTARTED: "the world has been started again",
}
"""Why a view was proposed."""


def _fence(_: str, fence: FenceChanged) -> str:
    match fence.may:
        case May.STOPPED:
            return "the operator has stopped all bodies"
        case May.ALL:
            return f"the strand may drive: {robot_name(fence.named)} leads {fence.members} robots"
        case May.ONE:
            return f"{robot_name(fence.named)} has the turn: it alone may drive"
        case May.NOBODY:
            if fence.cause is None:
                return "nobody has the turn: all stand"
            who = f": {robot_name(fence.coordinator)} coordinates a view" if fence.coordinator else ""
            return f"all bodies stand, because {CAUSES[fence.cause]}{who}"


def _stranded(_: str, stranded: RobotStranded) -> str:
    by = "" if stranded.by is None else f", the body of {robot_name(stranded.by)} is in the way"
    return f"{robot_name(stranded.robot)} is stranded: {stranded.reason}{by}"


def _fault(_: str, fault: FaultInjected) -> str:
    return f"{fault.rule}: {fault.fault} {fault.process or f'message {fault.number} on {fault.key}'}"


def _leader(by: str, leads: LeaderSucceeded) -> str:
    return f"{by} leads" + ("" if leads.before is None else f" instead of {robot_name(leads.before)}")


def _broken(by: str, link: LinkBroken) -> str:
    why = "whose token is gone" if link.cause == "token" else "whose token is there"
    return f"{by} breaks its link to {robot_name(link.neighbour)}, silent for {link.silent_s:.1f} s, {why}"


def _traffic(by: str, counted: TrafficCounted) -> str:
    sent, received = sum(counted.sent.values()), sum(counted.received.values())
    return f"{by} has sent {sent} messages and received {received}"


SENTENCES: dict[str, str | Callable[[str, Any], str]] = {
    "authority.granted": "{by} grants r{it.to} the path up to {it.authority_m:.3f} m",
    "body.stopped": "the body of r{it.robot} stops: its robot is silent",
    "fault.injected": _fault,
    "fence.changed": _fence,
    "goal.reached": "{by} has reached the goal",
    "law.failed": "{by} gets no step: {it.reason}",
    "law.stalled": "{by} waits for the law {it.law}: no return for {it.after_s:g} s, it is at {it.at}",
    "leader.succeeded": _leader,
    "link.broken": _broken,
    "link.heard": "{by} hears r{it.neighbour} again",
    "link.silent": "{by} has not heard r{it.neighbour} for {it.silent_s:.2f} s",
    "message.refused": "{by} refuses a message on {it.key}: {it.reason}",
    "order.accepted": _order,
    "order.finished": "the body of r{it.robot} finishes order {it.number}",
    "order.refused": "the body of r{it.robot} refuses order {it.number}: {it.reason}",
    "pose.sampled": "r{it.robot} is at ({it.x_m:.3f}, {it.y_m:.3f}), heading {it.heading_rad:.3f} rad",
    "promise.broken": lambda _, broken: (
        f"{named(broken.invariant)} broken by {robot_name(broken.robot)}: {broken.why}"
    ),
    "robot.appeared": "r{it.robot} has appeared",
    "robot.arrived": "{by} has arrived, at {it.progress_m:.3f} m of the path",
    "robot.blocked": "{by} is blocked: {it.reason}",
    "robot.died": "r{it.robot} has died, silent since t={it.silent_since_s:.1f} s",
    "robot.failed": "{by} has failed: {it.reason}",
    "robot.held": "{by} waits for the robot behind, which is {it.behind_m:.2f} m short of its authority",
    "robot.placed": lambda by, placed: f"{by} stands in place {placed.rank + 1}",
    "robot.released": "{by} no longer waits for the robot behind",
    "robot.restarted": "r{it.robot} has been restarted",
    "robot.returned": "r{it.robot} has returned",
    "robot.settled": lambda by, it: f"{by} sends no more: {sum(it.sent.values())} messages in all",
    "robot.started": "{by} starts, as process {it.pid}",
    "robot.stranded": _stranded,
    "route.lost": "{by} has lost its route: {it.reason}",
    "router.found": "a router is connected again, after {it.away_s:.3f} s of wall clock",
    "router.lost": "the router is lost: no message arrives",
    "run.ended": "the run is over: {it.reason}",
    "scan.served": "r{it.robot} takes a scan with {it.hits} hits",
    "segment.checked": _segment,
    "step.abandoned": "{by} gives up step {it.step}: for too long no scan has let it drive on",
    "step.finished": _step_end,
    "step.planned": _step,
    "strand.dissolved": "{by} dissolves the strand: the way of r{it.blocked} is blocked",
    "strand.formed": _strand,
    "strand.healed": "the strand has healed, with {it.robots} robots",
    "strand.joined": lambda by, joined: f"{by} takes place {joined.rank + 1} in the strand",
    "strand.reversed": "{by} has the strand turn round",
    "traffic.counted": _traffic,
    "view.joined": "{by} stands and reports to the coordinator",
    "view.left": "{by} is left out of the strand: it stands aside",
    "view.proposed": "{by} proposes a view: {it.why}",
    "world.resumed": "the world has been restarted, life {it.life}: it resumes from {it.entries} entries",
}
