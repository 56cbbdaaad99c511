"""Queries of tests about a rehearsal with a fault plan."""

from collections import Counter

from msgspec.structs import replace

from clew.rehearsal.rehearsal import Rehearsal
from protocol.faults.plan import PLANS
from protocol.faults.rules import Kill
from protocol.keys import robot_name
from protocol.timeline import FaultInjected

SHIPPED = sorted(path.stem for path in PLANS.glob("*.toml"))


def injected(rehearsal: Rehearsal) -> Counter[str]:
    """The number of injections of each fault."""
    records = (entry.record for _, entry in rehearsal.entries)
    return Counter(record.fault for record in records if isinstance(record, FaultInjected))


def kill(rehearsal: Rehearsal, robot: int) -> None:
    """End a robot's process by one more rule of the plan; its body stays."""
    plan = rehearsal.plan
    rehearsal.turn_to(replace(plan, rules=(*plan.rules, Kill(target=robot_name(robot)))))
