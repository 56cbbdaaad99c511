import pytest

from clew.fleet.supervision.events import FaultAsked, fault_in
from protocol.faults.process_faults import ProcessAction


@pytest.mark.parametrize(
    ("line", "fault"),
    [
        ("kill world", FaultAsked(ProcessAction.KILL, "world")),
        ("kill router 2.5", FaultAsked(ProcessAction.KILL, "router", 2.5)),
        ("freeze router-2 0", FaultAsked(ProcessAction.FREEZE, "router-2", 0.0)),
        ("thaw world", FaultAsked(ProcessAction.THAW, "world")),
        ("", None),
        ("nonsense", None),
        ("kill", None),
        ("maim world", None),
        ("kill world soon", None),
        ("kill world nan", None),
        ("kill world inf", None),
        ("kill world -1", None),
        ("kill world 1 2", None),
    ],
)
def test_process_fault_is_read_from_a_line(line: str, fault: FaultAsked | None) -> None:
    assert fault_in(line) == fault
