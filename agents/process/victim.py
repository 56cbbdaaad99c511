"""What a fault plan does to a robot at a named point of its step, done by the robot to itself. A shell.

Rule 1: a rule strikes once. A robot that was started again strikes itself only when it has been told which
        rules have: it might else die at the same point for ever.
Rule 2: its host is told before, by the run's private folder, that this was meant to be.
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
    """One robot's part of a fault plan."""

    def __init__(self, robot: int, sessions: Path, conditions: Conditions, *, again: bool) -> None:
        self._robot, self._name = robot, robot_name(robot)
        self._sessions = sessions
        self._process_faults = ProcessFaults(conditions.plan, conditions.seed)
        self._points = Points()
        self._again = again

    def note(self, record: Record, now_s: float) -> None:
        """The robot records something: it says who has which role."""
        self._process_faults.hear(self._name, Entry(n=1, t_s=now_s, hlc="", record=record))

    def struck(
        self, event: Event, commands: Sequence[Command], now_s: float, faults: Faults
    ) -> ProcessFault | None:
        """What the robot is to do to itself now, before it obeys these commands."""
        passed = self._points.passed(event, commands)
        self._process_faults.catch_up(faults.struck, faults.step)
        if self._again and faults.number == 0:
            return None
        due = self._process_faults.at_points(self._name, passed, now_s)
        return next((fault for fault in due if fault.action in SIGNALS), None)

    def strike(self, fault: ProcessFault) -> None:
        """Do it; returns when the process goes on, if ever."""
        send_to_hosts(self._sessions, HostCommand(action=fault.action, robot=self._robot, done=True))
        os.kill(os.getpid(), SIGNALS[fault.action])
