"""Which robots have no process, by the timeline. Pure: entries in, answers out.

Rule 1: a robot whose process a fault has killed, or which has failed, is dead until it is started again.
Rule 2: a robot that is missed (`robot.died`) is dead, unless it was frozen, or a partition may have cut it
        off: then its process exists, and a fault can strike it.
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
    """The robots without a process, by their names."""

    def __init__(self, rules: Iterable[Rule]) -> None:
        self._ended: set[str] = set()
        self._frozen: set[str] = set()
        self._may_be_cut_off = False
        self.expect(rules)

    def __contains__(self, process: str) -> bool:
        return process in self._ended

    def expect(self, rules: Iterable[Rule]) -> None:
        """Take these rules into account, too."""
        self._may_be_cut_off |= any(isinstance(rule, Partition) for rule in rules)

    def strike(self, process: str, action: str) -> None:
        """A fault does this to a process now."""
        if action == "kill" and robot_number(process) is not None:
            self._ended.add(process)
        elif action == "start":
            self._live(process)
        elif action == "freeze":
            self._frozen.add(process)
        elif action == "thaw":
            self._frozen.discard(process)

    def hear(self, source: str, entry: Entry) -> None:
        """Process a timeline entry."""
        match entry.record:
            case FaultInjected(fault=fault, process=str(process)):
                self.strike(process, fault)
            case RobotFailed():
                self._ended.add(source)
            case RobotDied(robot=robot):
                if robot_name(robot) not in self._frozen and not self._may_be_cut_off:
                    self._ended.add(robot_name(robot))
            case RobotStarted():
                self._live(source)
            case RobotRestarted(robot=robot) | RobotReturned(robot=robot):
                self._live(robot_name(robot))
            case _:
                pass

    def _live(self, robot: str) -> None:
        self._ended.discard(robot)
        self._frozen.discard(robot)
