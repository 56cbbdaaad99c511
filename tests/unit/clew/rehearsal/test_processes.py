"""What process faults do to the processes of a rehearsal."""

import pytest

from clew.rehearsal.processes import Processes
from protocol.faults.process_faults import ProcessAction, ProcessFault
from protocol.faults.rules import ROUTER
from protocol.keys import WORLD
from tests.support.stages.one_step import MISSION

KILL, START, FREEZE, THAW = ProcessAction.KILL, ProcessAction.START, ProcessAction.FREEZE, ProcessAction.THAW


def is_up(process: str, *actions: ProcessAction) -> bool:
    """Whether the world or the router runs after these faults."""
    processes = Processes(MISSION, seed=1)
    for now_s, action in enumerate(actions):
        processes.inject(ProcessFault("test", action, process), float(now_s))
    return not processes.desk.ended if process == WORLD else processes.router_is_up


@pytest.mark.parametrize("process", [WORLD, ROUTER])
@pytest.mark.parametrize(
    ("actions", "up"),
    [
        ((FREEZE,), False),
        ((FREEZE, THAW), True),
        ((FREEZE, KILL, THAW), False),
        ((FREEZE, KILL, THAW, START), True),
        ((FREEZE, KILL, START, THAW), True),
        ((FREEZE, THAW, KILL), False),
    ],
)
def test_a_thaw_brings_no_process_back_that_was_killed(
    process: str, actions: tuple[ProcessAction, ...], *, up: bool
) -> None:
    assert is_up(process, *actions) == up


def test_a_thaw_of_a_world_that_was_started_again_changes_nothing() -> None:
    processes = Processes(MISSION, seed=1)
    for action in (FREEZE, KILL, START):
        processes.inject(ProcessFault("test", action, WORLD), 1.0)
    desk = processes.desk
    processes.inject(ProcessFault("test", THAW, WORLD), 2.0)
    assert processes.desk is desk
