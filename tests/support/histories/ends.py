"""Why and how runs end."""

from signal import SIGCONT, SIGHUP, SIGINT, SIGKILL, SIGSTOP

from clew.fleet.supervision.events import (
    HOST,
    WORLD,
    Asked,
    Begun,
    Ended,
    Exit,
    FaultAsked,
    Gone,
    Judged,
    Say,
    Signal,
    Tick,
)
from clew.fleet.supervision.limits import Plan
from protocol.exit_codes import ExitCode
from protocol.faults.process_faults import ProcessAction
from tests.support.histories.told import (
    FLEET,
    KILLED_WORLD,
    ONE,
    R1,
    REST_IS_ASKED,
    UP,
    WORLD_IS_ASKED,
    WORLD_IS_FAILED,
    History,
    gone,
    kill,
    rest_ends,
    stop,
)

ENDS = {
    "a good run ends with its world": History(
        ONE,
        (
            *UP,
            *gone(9.0, HOST),
            (9.1, Judged(0), []),
            (9.1, Ended(WORLD, 0), []),
            (9.1, Gone(WORLD), stop(R1)),
            (9.2, Ended(R1, 143), []),
            (9.2, Gone(R1), [Exit(0)]),
            (9.3, Asked(ExitCode.TERMINATED), []),
            (9.3, Tick(), []),
        ),
    ),
    "the world's exit code is ours": History(
        ONE, (*UP, (9.1, Judged(1), []), (9.1, Ended(WORLD, 1), []), *rest_ends(9.1, 1))
    ),
    "a world that ends without a verdict is named": History(
        ONE, (*UP, (9.1, Ended(WORLD, 1), [Say("the world ended with exit code 1")]), *rest_ends(9.1, 1))
    ),
    "a world that refuses our own router has failed, as the request was already checked": History(
        ONE, (*UP, (1.0, Ended(WORLD, 2), [Say("the world ended with exit code 2")]), *rest_ends(1.0, 1))
    ),
    "a world that refuses the user's router refuses the request": History(
        Plan(routers=0),
        (
            (0.0, Begun(), FLEET),
            (1.0, Ended(WORLD, 2), [Say("the world ended with exit code 2")]),
            (1.0, Gone(WORLD), stop(HOST)),
            (1.1, Ended(HOST, 143), []),
            (1.1, Gone(HOST), [Exit(2)]),
        ),
    ),
    "a world that is killed after its verdict is not started again, and the run ends as that says": History(
        ONE, (*UP, (9.0, Judged(0), []), (9.0, Ended(WORLD, -9), []), *rest_ends(9.0, 0))
    ),
    "a part that is down when the run ends stays down": History(
        ONE,
        (
            *UP,
            (2.0, FaultAsked(ProcessAction.KILL, "world", 1.0), [Signal(WORLD, SIGKILL)]),
            (2.0, Ended(WORLD, -9), [KILLED_WORLD]),
            (2.0, Gone(WORLD), []),
            (2.9, Asked(ExitCode.TERMINATED), REST_IS_ASKED),
            (3.0, Tick(), []),
        ),
    ),
    "a host that fails ends the run, when the world has noticed": History(
        ONE,
        (
            *UP,
            (2.0, Ended(HOST, -9), [Say("the host was killed by SIGKILL before the world")]),
            (2.1, Ended(R1, -9), []),
            (2.1, Gone(R1), []),
            (3.2, Judged(1), []),
            (3.2, Ended(WORLD, 1), []),
            (3.2, Gone(WORLD), stop(HOST)),  # some of its robots are left
            (3.3, Gone(HOST), [Exit(1)]),
        ),
    ),
    "a host that ends with a robot that somebody has ended does not end the run before the world": History(
        ONE,
        (
            *UP,
            (9.0, Ended(HOST, 143), []),
            (9.0, Gone(HOST), []),
            (9.2, Judged(0), []),
            (9.2, Ended(WORLD, 0), []),
            (9.2, Gone(WORLD), stop(R1)),
            (9.3, Ended(R1, 143), []),
            (9.3, Gone(R1), [Exit(0)]),
        ),
    ),
    "a host that ends before a world that goes on has failed": History(
        ONE,
        (
            *UP,
            (9.0, Ended(HOST, 2), []),
            (9.0, Gone(HOST), []),
            (10.5, Tick(), [Say("the host ended with exit code 2 before the world"), *WORLD_IS_FAILED]),
        ),
    ),
    "a host that fails while the world is down ends the run at once": History(
        ONE,
        (
            *UP,
            (2.0, FaultAsked(ProcessAction.KILL, "world", 9.0), [Signal(WORLD, SIGKILL)]),
            (2.0, Ended(WORLD, -9), [KILLED_WORLD]),
            (2.0, Gone(WORLD), []),
            (3.0, Ended(HOST, 1), [Say("the host ended with exit code 1 before the world"), *REST_IS_ASKED]),
        ),
    ),
    "Ctrl-C has the world write its verdict, and a second one changes nothing": History(
        ONE,
        (
            *UP,
            (2.0, Asked(ExitCode.INTERRUPTED), [Signal(WORLD, SIGINT), Signal(WORLD, SIGCONT)]),
            (2.1, Asked(ExitCode.INTERRUPTED), []),
            (2.2, Asked(ExitCode.TERMINATED), []),
            *gone(2.5, HOST),
            (2.6, Judged(130), []),
            (2.6, Ended(WORLD, 130), []),
            (2.6, Gone(WORLD), stop(R1)),
            (2.7, Ended(R1, 143), []),
            (2.7, Gone(R1), [Exit(130)]),
        ),
    ),
    "a closed terminal is told to the world as SIGHUP, so that verdict and launcher say the same": History(
        ONE,
        (
            *UP,
            (2.0, Asked(ExitCode.HUNG_UP), [Signal(WORLD, SIGHUP), Signal(WORLD, SIGCONT)]),
            *gone(2.5, HOST),
            (2.6, Judged(129), []),
            (2.6, Ended(WORLD, 129), []),
            (2.6, Gone(WORLD), stop(R1)),
            (2.7, Ended(R1, 143), []),
            (2.7, Gone(R1), [Exit(129)]),
        ),
    ),
    "SIGHUP ends a run that waits for its router": History(
        ONE,
        (
            *UP[:1],
            (0.1, Asked(ExitCode.HUNG_UP), stop(R1)),
            (0.2, Ended(R1, 143), []),
            (0.2, Gone(R1), [Exit(129)]),
        ),
    ),
    "a run that was asked to end before it began starts nothing": History(
        ONE, ((0.0, Asked(ExitCode.TERMINATED), [Exit(143)]), (0.0, Begun(), []))
    ),
    "a frozen world is killed in time and reported": History(
        ONE,
        (
            *UP,
            (2.0, Asked(ExitCode.TERMINATED), WORLD_IS_ASKED),
            (4.9, Tick(), []),
            (5.0, Tick(), [*stop(R1), *stop(WORLD), *stop(HOST)]),
            *gone(5.1, R1, 143),
            *gone(5.1, HOST, 143),
            (
                5.4,
                Tick(),
                [Say("the world had not ended 3.4 s after it was asked to, and was killed"), kill(WORLD)],
            ),
            (5.4, Ended(WORLD, -9), []),
            (5.4, Gone(WORLD), [Exit(143)]),
        ),
    ),
    "a slow end is not reported if the verdict was written": History(
        ONE,
        (
            *UP,
            (9.0, Judged(0), []),
            (9.0, Ended(WORLD, 0), []),
            (9.0, Gone(WORLD), REST_IS_ASKED),
            (9.4, Tick(), [kill(R1), kill(HOST)]),
            (9.5, Ended(R1, -9), []),
            (9.5, Gone(R1), []),
            (9.8, Tick(), [Exit(0)]),
        ),
    ),
    "a router that is slow to end is not reported, even without a verdict": History(
        ONE, (*UP[:1], (0.1, Asked(ExitCode.TERMINATED), stop(R1)), (0.5, Tick(), [kill(R1)]))
    ),
    "with a world that does not notice, the end takes no longer": History(
        ONE,
        (
            *UP,
            (2.0, Ended(HOST, -9), [Say("the host was killed by SIGKILL before the world")]),
            (2.0, Gone(HOST), []),
            (3.5, Tick(), WORLD_IS_FAILED),
            (5.9, Tick(), []),
            (6.0, Tick(), [*stop(R1), *stop(WORLD)]),
            *gone(6.1, R1),
            (
                6.4,
                Tick(),
                [Say("the world had not ended 2.9 s after it was asked to, and was killed"), kill(WORLD)],
            ),
            (6.81, Tick(), [Exit(1)]),
        ),
    ),
    "a part that a fault has frozen is thawed when the run ends": History(
        ONE,
        (
            *UP,
            (2.0, FaultAsked(ProcessAction.FREEZE, "router", 1.5), [Signal(R1, SIGSTOP)]),
            (2.0, FaultAsked(ProcessAction.FREEZE, "world"), [Signal(WORLD, SIGSTOP)]),
            (3.0, Asked(ExitCode.TERMINATED), [*WORLD_IS_ASKED, Signal(R1, SIGCONT)]),
            (3.5, Tick(), []),
            (3.6, FaultAsked(ProcessAction.FREEZE, "world"), []),
        ),
    ),
    "a part that is frozen while the run ends is thawed, so the user need not wait": History(
        ONE,
        (
            *UP,
            (2.0, Ended(HOST, -9), [Say("the host was killed by SIGKILL before the world")]),
            (2.0, Gone(HOST), []),
            (2.1, FaultAsked(ProcessAction.FREEZE, "world", 0.5), [Signal(WORLD, SIGSTOP)]),
            (2.6, Tick(), [Signal(WORLD, SIGCONT)]),
            (3.0, Asked(ExitCode.TERMINATED), WORLD_IS_ASKED),
            (5.9, Tick(), []),
            (6.0, Tick(), [*stop(R1), *stop(WORLD)]),
        ),
    ),
}
