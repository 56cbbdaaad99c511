"""How runs begin, which parts they lose, and which of them are restarted."""

from signal import SIGCONT, SIGKILL, SIGSTOP

from clew.fleet.supervision.events import (
    HOST,
    TABLE,
    VIEWER,
    WORLD,
    Activate,
    Asked,
    Begun,
    Ended,
    Exit,
    FaultAsked,
    Gone,
    Judged,
    MendTerminal,
    Ready,
    Say,
    Signal,
    Start,
    Tick,
)
from clew.fleet.supervision.limits import Plan
from protocol.exit_codes import ExitCode
from protocol.faults.process_faults import ProcessAction
from tests.support.histories.told import (
    FLEET,
    KILLED_ROUTER,
    KILLED_WORLD,
    ONE,
    PAGE,
    R1,
    R2,
    UP,
    UP_WITH_TABLE,
    UP_WITH_TWO,
    WORLD_IS_ASKED,
    WORLD_IS_FAILED,
    History,
    Step,
    again,
    gone,
    rest_ends,
    stop,
)

ROUTER_SPENT = Say("router 1 was killed by SIGKILL once too often")


def world_dies(at_s: float) -> tuple[Step, ...]:
    return (
        (at_s, Ended(WORLD, -9), [KILLED_WORLD, Start(WORLD, resume=True)]),
        (at_s, Gone(WORLD), []),
    )


def router_dies(at_s: float) -> tuple[Step, ...]:
    return (
        (at_s, Ended(R1, -9), [KILLED_ROUTER, Start(R1)]),
        (at_s, Gone(R1), []),
        (at_s, Ready(R1), []),
    )


LOSSES = {
    "a killed world is restarted five times at most": History(
        ONE,
        (
            *UP,
            *(step for at_s in range(1, 6) for step in world_dies(at_s)),
            (6.0, Ended(WORLD, -9), [Say("the world was killed by SIGKILL")]),
            *rest_ends(6.0, 137),
        ),
    ),
    "a router that ends is restarted ten times at most, and the world may notice": History(
        ONE,
        (
            *UP,
            *(step for at_s in range(1, 11) for step in router_dies(at_s)),
            (11.0, Ended(R1, -9), [ROUTER_SPENT]),
            (11.0, Gone(R1), []),
            (12.4, Tick(), []),
            (12.5, Tick(), WORLD_IS_FAILED),
            (12.6, Ended(WORLD, 143), []),
            (12.6, Gone(WORLD), stop(HOST)),
            (12.7, Ended(HOST, 143), []),
            (12.7, Gone(HOST), [Exit(1)]),
        ),
    ),
    "a router that a fault keeps down is restarted when its time is over": History(
        ONE,
        (
            *UP,
            (2.0, FaultAsked(ProcessAction.KILL, "router", 2.5), [Signal(R1, SIGKILL)]),
            (2.1, Ended(R1, -9), [KILLED_ROUTER]),
            (2.1, Gone(R1), []),
            (4.5, Tick(), []),
            (4.6, Tick(), [Start(R1)]),
            (9.0, Ended(R1, -15), [again("router 1 was killed by SIGTERM"), Start(R1)]),
        ),
    ),
    "a world that a fault keeps down is restarted when its time is over": History(
        ONE,
        (
            *UP,
            (2.0, FaultAsked(ProcessAction.KILL, "world", 1.0), [Signal(WORLD, SIGKILL)]),
            (2.0, Ended(WORLD, -9), [KILLED_WORLD]),
            (2.5, FaultAsked(ProcessAction.KILL, "world"), []),
            (3.0, Tick(), [Start(WORLD, resume=True)]),
        ),
    ),
    "the second router takes over when the active one has died": History(
        Plan(routers=2),
        (
            *UP_WITH_TWO,
            (2.0, Ended(R1, -9), [KILLED_ROUTER, Activate(R2), Start(R1)]),
            (2.1, Ended(R1, -9), [KILLED_ROUTER, Start(R1)]),
            (3.0, FaultAsked(ProcessAction.KILL, "router"), [Signal(R2, SIGKILL)]),
            (3.0, Ended(R2, -9), [again("router 2 was killed by SIGKILL"), Activate(R1), Start(R2)]),
        ),
    ),
    "a router that dies while the other one starts is restarted, without a third one": History(
        Plan(routers=2),
        (
            *UP_WITH_TWO[:2],
            (0.4, Ended(R1, 0), [again("router 1 ended with exit code 0"), Activate(R2), Start(R1)]),
            (0.5, Ready(R1), []),
            (0.6, Ready(R2), FLEET),
        ),
    ),
    "a router that cannot listen has printed the reason, and the run is refused": History(
        ONE, (*UP[:1], (0.2, Ended(R1, 2), stop(R1)), (0.2, Gone(R1), [Exit(2)]))
    ),
    "a router that fails before it listens ends the run": History(
        ONE,
        (
            *UP[:1],
            (0.2, Ended(R1, -11), [Say("router 1 was killed by SIGSEGV before it was ready"), *stop(R1)]),
            (0.2, Gone(R1), [Exit(1)]),
        ),
    ),
    "a router that does not listen in 60 s ends the run": History(
        Plan(routers=2),
        (
            *UP_WITH_TWO[:2],
            (60.2, Tick(), []),
            (60.3, Tick(), [Say("the router is not ready after 60 s"), *stop(R1), *stop(R2)]),
            *gone(60.4, R2, 143),
            (60.4, Ended(R1, 143), []),
            (60.4, Gone(R1), [Exit(1)]),
        ),
    ),
    "the world waits for the page": History(
        Plan(view=True),
        (
            (0.0, Begun(), [Start(VIEWER), Activate(R1), Start(R1)]),
            (0.3, Ready(R1), []),
            (0.9, Ready(VIEWER, PAGE), [Say(f"the page is at {PAGE}"), *FLEET]),
            (2.0, Ended(VIEWER, 1), [Say("the viewer ended with exit code 1; the run goes on")]),
        ),
    ),
    "a page may be ready before the router": History(
        Plan(view=True),
        (
            (0.0, Begun(), [Start(VIEWER), Activate(R1), Start(R1)]),
            (0.2, Ready(VIEWER, PAGE), [Say(f"the page is at {PAGE}")]),
            (0.3, Ready(R1), FLEET),
        ),
    ),
    "the world does not wait for a viewer that has died": History(
        Plan(view=True),
        (
            (0.0, Begun(), [Start(VIEWER), Activate(R1), Start(R1)]),
            (0.3, Ready(R1), []),
            (0.4, Ended(VIEWER, -6), [Say("the viewer was killed by SIGABRT; the run goes on"), *FLEET]),
        ),
    ),
    "the world waits 10 s for a page and no longer": History(
        Plan(view=True),
        (
            (0.0, Begun(), [Start(VIEWER), Activate(R1), Start(R1)]),
            (0.3, Ready(R1), []),
            (10.2, Tick(), []),
            (10.3, Tick(), FLEET),
            (11.0, Ready(VIEWER, PAGE), [Say(f"the page is at {PAGE}")]),
            (12.0, Asked(ExitCode.TERMINATED), WORLD_IS_ASKED),
            (12.0, Ended(VIEWER, 143), []),
        ),
    ),
    "after a table fails, the terminal is restored and the run continues": History(
        Plan(table=True),
        (
            *UP_WITH_TABLE,
            (
                2.0,
                Ended(TABLE, -9),
                [MendTerminal(), Say("the table was killed by SIGKILL; the run goes on")],
            ),
        ),
    ),
    "the normal end of the table is not reported": History(
        Plan(table=True), (*UP_WITH_TABLE, (9.0, Judged(0), []), (9.1, Ended(TABLE, 0), []))
    ),
    "a part that is frozen for a time is thawed after it": History(
        ONE,
        (
            *UP,
            (2.0, FaultAsked(ProcessAction.FREEZE, "world", 1.5), [Signal(WORLD, SIGSTOP)]),
            (3.4, Tick(), []),
            (3.5, Tick(), [Signal(WORLD, SIGCONT)]),
            (4.0, FaultAsked(ProcessAction.FREEZE, "world", 1.0), [Signal(WORLD, SIGSTOP)]),
            (4.5, FaultAsked(ProcessAction.THAW, "world"), [Signal(WORLD, SIGCONT)]),
            (5.0, Tick(), []),
        ),
    ),
    "a part that is killed while frozen is not thawed": History(
        ONE,
        (
            *UP,
            (2.0, FaultAsked(ProcessAction.FREEZE, "router", 5.0), [Signal(R1, SIGSTOP)]),
            (3.0, FaultAsked(ProcessAction.KILL, "router"), [Signal(R1, SIGKILL)]),
            (3.0, Ended(R1, -9), [KILLED_ROUTER, Start(R1)]),
            (7.0, Tick(), []),
        ),
    ),
    "a fault on a process that is missing, or that another program controls, does nothing": History(
        ONE,
        (
            (0.0, FaultAsked(ProcessAction.KILL, "router"), []),
            *UP,
            (2.0, FaultAsked(ProcessAction.FREEZE, "nobody"), []),
            (2.0, FaultAsked(ProcessAction.START, "world"), []),
            (2.0, FaultAsked(ProcessAction.SLOW, "world"), []),
        ),
    ),
    "an old process group that ends late does not hide the new process": History(
        ONE,
        (
            *UP,
            (2.0, Ended(WORLD, -9), [KILLED_WORLD, Start(WORLD, resume=True)]),
            (2.1, Gone(WORLD), []),
            (2.2, Asked(ExitCode.TERMINATED), WORLD_IS_ASKED),
        ),
    ),
    "process faults begin and end while routers start": History(
        Plan(routers=2, view=True),
        (
            (0.0, Begun(), [Start(VIEWER), Activate(R1), Start(R1)]),
            (0.3, Ready(R1), [Start(R2)]),
            (0.4, FaultAsked(ProcessAction.FREEZE, R1, 0.1), [Signal(R1, SIGSTOP)]),
            (0.5, Tick(), [Signal(R1, SIGCONT)]),
            (0.6, FaultAsked(ProcessAction.KILL, R1, 0.1), [Signal(R1, SIGKILL)]),
            (0.6, Ended(R1, -9), [KILLED_ROUTER, Activate(R2)]),
            (0.7, Tick(), [Start(R1)]),
            (0.8, Ended(VIEWER, -9), [Say("the viewer was killed by SIGKILL; the run goes on")]),
            (0.9, Ready(R2), FLEET),
        ),
    ),
    "process faults begin and end while the page is awaited": History(
        Plan(view=True),
        (
            (0.0, Begun(), [Start(VIEWER), Activate(R1), Start(R1)]),
            (0.3, Ready(R1), []),
            (0.4, FaultAsked(ProcessAction.FREEZE, "router", 0.1), [Signal(R1, SIGSTOP)]),
            (0.5, Tick(), [Signal(R1, SIGCONT)]),
            (0.6, FaultAsked(ProcessAction.KILL, "router", 0.1), [Signal(R1, SIGKILL)]),
            (0.6, Ended(R1, -9), [KILLED_ROUTER]),
            (0.7, Tick(), [Start(R1)]),
            (0.8, Asked(ExitCode.INTERRUPTED), [*stop(VIEWER), *stop(R1)]),
        ),
    ),
    "a router that keeps dying while the page is awaited ends the run": History(
        Plan(view=True),
        (
            (0.0, Begun(), [Start(VIEWER), Activate(R1), Start(R1)]),
            (0.3, Ready(R1), []),
            *(step for _ in range(10) for step in router_dies(1.0)),
            (
                2.0,
                Ended(R1, -9),
                [ROUTER_SPENT, *stop(VIEWER), *stop(R1)],
            ),
        ),
    ),
    "a router that keeps dying while the other one starts ends the run": History(
        Plan(routers=2),
        (
            *UP_WITH_TWO[:2],
            (1.0, Ended(R1, -9), [KILLED_ROUTER, Activate(R2), Start(R1)]),
            *(step for _ in range(9) for step in router_dies(1.0)),
            (
                2.0,
                Ended(R1, -9),
                [ROUTER_SPENT, *stop(R1), *stop(R2)],
            ),
        ),
    ),
}
