"""The sentence for each kind of entry: the only place that words entries for users.

Rule 1: the sentence of a kind is a template over its fields, or a function where a template is not enough.
Rule 2: robots are written as `r3`; `by` is the source of the entry.
"""

from collections.abc import Callable
from typing import Any

from protocol.keys import robot_name
from protocol.timeline import (
    AuthorityGranted,
    BodyStopped,
    FaultInjected,
    GoalReached,
    LeaderSucceeded,
    LinkBroken,
    LinkHeard,
    LinkSilent,
    MessageRefused,
    MusterCalled,
    MusterJoined,
    OrderAccepted,
    OrderFinished,
    OrderRefused,
    PoseSampled,
    PromiseBroken,
    Record,
    RobotAppeared,
    RobotArrived,
    RobotBlocked,
    RobotDied,
    RobotFailed,
    RobotHeld,
    RobotPlaced,
    RobotReleased,
    RobotRestarted,
    RobotReturned,
    RobotSettled,
    RobotStarted,
    RouteLost,
    RouterFound,
    RouterLost,
    RunEnded,
    ScanServed,
    SegmentChecked,
    StepAbandoned,
    StepFinished,
    StepPlanned,
    StrandDissolved,
    StrandFormed,
    StrandHealed,
    StrandReversed,
    TrafficCounted,
    WorldResumed,
)


def sentence(source: str, record: Record) -> str:
    """The sentence for an entry of this source, in plain English."""
    said = SENTENCES[type(record)]
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


def _strand(by: str, formed: StrandFormed) -> str:
    strand = " < ".join(map(robot_name, formed.order))
    is_leader = by == robot_name(formed.order[0])
    return f"strand formed: {strand}" if is_leader else f"{by} takes its place in the strand {strand}"


def _fault(_: str, fault: FaultInjected) -> str:
    return f"{fault.rule}: {fault.fault} {fault.process or f'message {fault.number} on {fault.key}'}"


def _leader(by: str, leads: LeaderSucceeded) -> str:
    return f"{by} leads" + ("" if leads.before is None else f" instead of {robot_name(leads.before)}")


def _traffic(by: str, counted: TrafficCounted) -> str:
    sent, received = sum(counted.sent.values()), sum(counted.received.values())
    return f"{by} has sent {sent} messages and received {received}"


SENTENCES: dict[type[Record], str | Callable[[str, Any], str]] = {
    AuthorityGranted: "{by} grants r{it.to} the path up to {it.authority_m:.3f} m",
    BodyStopped: "the body of r{it.robot} stops: its robot is silent",
    FaultInjected: _fault,
    GoalReached: "{by} has reached the goal",
    LeaderSucceeded: _leader,
    LinkBroken: "{by} breaks its link to r{it.neighbour}, silent for {it.silent_s:.1f} s ({it.cause})",
    LinkHeard: "{by} hears r{it.neighbour} again",
    LinkSilent: "{by} has not heard r{it.neighbour} for {it.silent_s:.2f} s",
    MessageRefused: "{by} refuses a message on {it.key}: {it.reason}",
    MusterCalled: lambda by, call: f"{by} calls {len(call.members)} robots to line up: {call.why}",
    MusterJoined: "{by} leaves its strand to line up",
    OrderAccepted: _order,
    OrderFinished: "the body of r{it.robot} finishes order {it.number}",
    OrderRefused: "the body of r{it.robot} refuses order {it.number}: {it.reason}",
    PoseSampled: "r{it.robot} is at ({it.x_m:.3f}, {it.y_m:.3f}), heading {it.heading_rad:.3f} rad",
    PromiseBroken: "{it.invariant} broken by r{it.robot}: {it.why}",
    RobotAppeared: "r{it.robot} has appeared",
    RobotArrived: "{by} has arrived, at {it.progress_m:.3f} m of the path",
    RobotBlocked: "{by} is blocked: {it.reason}",
    RobotDied: "r{it.robot} has died, silent since t={it.silent_since_s:.1f} s",
    RobotFailed: "{by} has failed: {it.reason}",
    RobotHeld: "{by} waits for the robot behind, which is {it.behind_m:.2f} m short of its authority",
    RobotPlaced: lambda by, placed: f"{by} has joined the strand, at place {placed.rank + 1}",
    RobotReleased: "{by} no longer waits for the robot behind",
    RobotRestarted: "r{it.robot} has been restarted",
    RobotReturned: "r{it.robot} has returned",
    RobotSettled: lambda by, it: f"{by} sends no more: {sum(it.sent.values())} messages in all",
    RobotStarted: "{by} starts, as process {it.pid}",
    RouteLost: "{by} knows no way to the goal: {it.reason}",
    RouterFound: "a router is connected again, after {it.away_s:.3f} s of wall clock",
    RouterLost: "the router is lost: no message arrives",
    RunEnded: "the run is over: {it.reason}",
    ScanServed: "r{it.robot} takes a scan with {it.hits} hits",
    SegmentChecked: _segment,
    StepAbandoned: "{by} stops before the end of step {it.step}",
    StepFinished: _step_end,
    StepPlanned: _step,
    StrandDissolved: "{by} dissolves the strand: the way of r{it.blocked} is blocked",
    StrandFormed: _strand,
    StrandHealed: lambda _, healed: f"the strand has healed, with {len(healed.members)} robots",
    StrandReversed: "{by} reverses the strand",
    TrafficCounted: _traffic,
    WorldResumed: "the world has been restarted, life {it.life}: it resumes from {it.entries} entries",
}
