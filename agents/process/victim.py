"""Injects faults at named points of a robot's step into the robot's own process. A shell.

Rule 1: a rule takes effect once. A restarted robot waits until it knows which rules have taken effect:
        otherwise it might die at the same point for ever.
Rule 2: the robot tells its host first, by the run's private folder, that the fault is intended.
Rule 3: of several faults due at a point the last is injected: no fault follows a kill, and one freeze is as
        good as two. All are recorded.
"""

import os
import signal
from collections.abc import Sequence
from pathlib import Path

from agents.commands import Command
from agents.events import Event
from agents.process.points import Points
from protocol.faults.process_commands import HostCommand, send_to_hosts
from protocol.faults.process_faults import ProcessAction, ProcessFault, ProcessFaults
from protocol.keys import robot_name
from protocol.network.faulty_transport import Conditions
from protocol.timeline import Entry, Record
from protocol.wire.messages import Faults

SIGNALS = {ProcessAction.KILL: signal.SIGKILL, ProcessAction.FREEZE: signal.SIGSTOP}


class Victim:
    """The process faults of one robot."""

    def __init__(self, robot: int, sessions: Path, conditions: Conditions, *, again: bool) -> None:
        self._robot, self._name = robot, robot_name(robot)
        self._sessions = sessions
        self._process_faults = ProcessFaults(conditions.plan, conditions.seed)
        self._points = Points()
        self._again = again

    def note(self, record: Record, now_s: float) -> None:
        """Read an entry of the robot: roles of robots follow from it."""
        if not self._process_faults.has_points:
            return
        self._process_faults.hear(self._name, Entry(n=1, t_s=now_s, hlc="", record=record))

    def faults_at(
        self, event: Event, commands: Sequence[Command], now_s: float, faults: Faults
    ) -> Sequence[ProcessFault]:
        """The faults that strike now, before these commands are executed."""
        if not self._process_faults.has_points:
            return ()
        passed = self._points.passed(event, commands)
        self._process_faults.catch_up(faults.struck, faults.step)
        if self._again and faults.number == 0:
            return ()
        return self._process_faults.at_points(self._name, passed, now_s)

    def inject(self, fault: ProcessFault) -> None:
        """Inject the fault; returns when the process goes on, if ever."""
        send_to_hosts(self._sessions, HostCommand(action=fault.action, robot=self._robot, done=True))
        os.kill(os.getpid(), SIGNALS[fault.action])
