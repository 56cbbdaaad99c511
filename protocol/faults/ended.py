"""The robots without a process, and frozen processes, by the timeline. Pure: entries in, answers out.

Rule 1: a robot that was killed by a fault, or has failed, is dead until it is restarted.
Rule 2: a robot that the world declares dead (`robot.died`) is dead, unless it was frozen or a partition may
        have cut it off. In those cases its process exists, and a fault can strike it.
Rule 3: a process is frozen from its freeze to its thaw or its next start. Messages that it sent before may
        still arrive, so they say nothing of it.
"""

from collections.abc import Iterable

from protocol.faults.rules import Partition, Rule
from protocol.keys import robot_name, robot_number
from protocol.timeline import (
    Entry,
    FaultInjected,
    RobotDied,
    RobotFailed,
    RobotRestarted,
    RobotReturned,
    RobotStarted,
)


class Ended:
    """The names of the robots without a process; and which processes are frozen."""

    def __init__(self, rules: Iterable[Rule], frozen: Iterable[str] = ()) -> None:
        self._ended: set[str] = set()
        self._frozen = set(frozen)
        self._may_be_cut_off = False
        self.expect(rules)

    def __contains__(self, process: str) -> bool:
        return process in self._ended

    @property
    def frozen(self) -> frozenset[str]:
        """The processes that a fault has frozen and none has thawed."""
        return frozenset(self._frozen)

    def expect(self, rules: Iterable[Rule]) -> None:
        """Take these further rules into account."""
        self._may_be_cut_off |= any(isinstance(rule, Partition) for rule in rules)

    def note_action(self, process: str, action: str) -> None:
        """Note an action on a process."""
        if action == "kill" and robot_number(process) is not None:
            self._ended.add(process)
        elif action == "start":
            self._note_alive(process)
        elif action == "freeze":
            self._frozen.add(process)
        elif action == "thaw":
            self._frozen.discard(process)

    def hear(self, source: str, entry: Entry) -> None:
        """Process a timeline entry."""
        match entry.record:
            case FaultInjected(fault=fault, process=str(process)):
                self.note_action(process, fault)
            case RobotFailed():
                self._ended.add(source)
            case RobotDied(robot=robot):
                if robot_name(robot) not in self._frozen and not self._may_be_cut_off:
                    self._ended.add(robot_name(robot))
            case RobotStarted():
                self._note_alive(source)
            case RobotRestarted(robot=robot):
                self._note_alive(robot_name(robot))
            case RobotReturned(robot=robot):
                self._ended.discard(robot_name(robot))
            case _:
                pass

    def _note_alive(self, robot: str) -> None:
        self._ended.discard(robot)
        self._frozen.discard(robot)
