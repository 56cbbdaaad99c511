"""What robots hold in memory: only the one that leads has the cells of a map."""

from collections.abc import Callable
from typing import Any

from agents.navigation.pricing import Cells
from clew.bench.soak import endless_queue
from clew.rehearsal.rehearsal import Rehearsal
from protocol.exit_codes import ExitCode
from protocol.faults.plan import Plan
from protocol.faults.rules import Restart
from protocol.timeline import RobotPlaced, StrandFormed

LEADER, MIDDLE, TAIL = "r1", "r3", "r5"
UNTIL_S = 22.0


def test_in_a_queue_whose_robots_are_restarted_only_the_leader_holds_the_cells_of_a_map(
    held: Callable[[type], list[Any]],
) -> None:
    rules = [
        Restart(target=target, from_s=from_s, after_s=0.5)
        for target, from_s in ((LEADER, 3.0), (MIDDLE, 8.0), (TAIL, 13.0))
    ]
    fleet = Rehearsal(endless_queue(5, wall_s=60.0, speed=0.5), 1, Plan(name="restarts", rules=tuple(rules)))
    next(now_s for now_s in fleet.ticks() if now_s > UNTIL_S)
    fleet.stop(ExitCode.INTERRUPTED)
    records = [entry.record for _, entry in fleet.entries]
    assert sum(isinstance(each, StrandFormed) for each in records) > len(rules), "each restart forms a strand"
    assert sum(isinstance(each, RobotPlaced) for each in records) > 1, "robots had turns"
    assert len(held(Cells)) <= 1
