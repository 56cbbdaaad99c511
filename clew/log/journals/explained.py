"""What no input explains: that nothing came, and that a robot has no place in a formation.

Rule 1: a decision that notes silence, or proposes a view for it, is explained by `clew.log.journals.silence`.
        One for a token that has gone has an input, and is not explained here.
Rule 2: a robot that is left out is explained by the draft of the coordinator when it made the formation, by
        replay, and by what led to that: silence, the end of a process, or turns in vain.
"""

from collections.abc import Callable, Iterator, Sequence

from agents.commands import Command, Note, Put, Say
from agents.coordinating.reported import TOO_SILENT, UNREPORTED
from agents.process import addresses
from clew.log.journals.links import Link, of_entry
from clew.log.journals.process import Process
from clew.log.journals.silence import Silence
from clew.log.journals.state import left_out, names
from clew.log.journals.trials import Deed, Trials
from protocol.fence import Cause, Raise
from protocol.keys import WORLD, robot_name
from protocol.timeline import (
    BodyStopped,
    Entry,
    FenceChanged,
    LinkBroken,
    LinkSilent,
    RobotBlocked,
    RobotDied,
    RobotStranded,
    StrandFormed,
    ViewLeft,
    ViewProposed,
)
from protocol.wire.view import Answer
from world.record.lines import Line

LAG_S = 0.2  # a robot's clock is that of its newest odometry
TOKEN_S = 2.0  # a token goes by then after its process


class Explained:
    """Explanations of what the decisions of a run's robots rest on, oldest first; empty: there is none."""

    def __init__(
        self, processes: Sequence[Process], lines: Sequence[Line], trials: Callable[[Process], Trials]
    ) -> None:
        self._lines, self._trials = lines, trials
        self._silence = Silence(processes, lines)

    def of(self, process: Process, turn: int, deed: Deed) -> list[Link]:
        """Why a process did something."""
        commands = [*process.commands(turn)]
        for command in filter(deed, commands):
            match command:
                case Note(LinkSilent(neighbour=other) | LinkBroken(neighbour=other, cause="silence")):
                    return self._unheard(process, other, addresses.link, turn)
                case Note(ViewProposed()) | Put(Raise()):
                    return self._lost(process, commands, turn)
                case Note(ViewLeft(epoch=number)):  # what a coordinator answers itself is in no journal
                    return self._left_out(process, process.robot, number)
                case Say(robot, Answer(out=True, epoch=epoch)) | Note(
                    RobotStranded(robot=robot, epoch=epoch)
                ):
                    number = epoch if isinstance(epoch, int) else epoch.number
                    return self._left_out(process, robot, number)
                case _:
                    pass
        return []

    def by_world(self, entry: Entry, deadman_s: float) -> list[Link]:
        """Why the world recorded that it heard nothing of a robot."""
        match entry.record:
            case BodyStopped(robot=robot):
                from_s = entry.t_s - deadman_s - LAG_S
            case RobotDied(robot=robot, silent_since_s=from_s):
                pass
            case _:
                return []
        return self._silence.between(WORLD, robot, {addresses.drive(robot)}, from_s, entry.t_s)

    def gone(self, robot: int, t_s: float) -> list[Link]:
        """Why a token went."""
        return [*self._silence.struck(robot_name(robot), t_s - TOKEN_S, t_s + LAG_S)]

    def _lost(self, process: Process, commands: Sequence[Command], turn: int) -> list[Link]:
        """Rule 1: a view was proposed for a robot that is lost."""
        notes = [command.record for command in commands if isinstance(command, Note)]
        if any(isinstance(each, LinkBroken) and each.cause == "token" for each in notes):
            return []
        for each in notes:
            match each:
                case ViewProposed(cause=Cause.NEIGHBOUR_LOST, about=int(other)):
                    return self._unheard(process, other, addresses.link, turn)
                case ViewProposed(cause=Cause.COORDINATOR_LOST, about=int(other), why=why) if "silent" in why:
                    return self._unheard(process, other, addresses.view, turn)
                case _:
                    pass
        return []

    def _unheard(
        self, process: Process, speaker: int, family: Callable[[int, int], str], turn: int
    ) -> list[Link]:
        keys = {family(speaker, process.robot)}
        heard, to_s = self._silence.heard(process, keys, turn), process.turns[turn].input.now_s
        from_s = 0.0 if heard is None else heard.t_s
        found = self._silence.between(process.name, speaker, keys, from_s, to_s)
        return [*([] if heard is None else [heard]), *found]

    def _left_out(self, process: Process, robot: int, epoch: int) -> list[Link]:
        """Rule 2."""
        for turn in range(len(process.turns)):
            for command in process.commands(turn, only=Note):
                match command:
                    case Note(StrandFormed(epoch=formed) as strand) if formed == epoch:
                        return self._by_draft(process, turn, robot, strand)
                    case _:
                        pass
        return []

    def _by_draft(self, process: Process, turn: int, robot: int, strand: StrandFormed) -> list[Link]:
        now_s = process.turns[turn].input.now_s
        drafted = self._trials(process).core_after(turn).drafted(now_s)
        assert drafted is not None, "it has made the formation"
        said = f"makes the strand {names(strand.order)} of epoch {strand.epoch}; left out {left_out(drafted)}"
        formed = Link(now_s, process.name, "draft", said, turn + 1)
        begun_s = min((t_s for t_s, _ in self._fences(strand.epoch)), default=0.0)
        key = addresses.view(robot, process.robot)
        match drafted.left_out.get(robot):
            case why if why == UNREPORTED:
                found = self._silence.between(process.name, robot, {key}, begun_s, now_s)
            case why if why == TOO_SILENT:
                found = self._broken(process, turn, robot)
            case _:
                found = [
                    *self._silence.struck(robot_name(robot), begun_s, now_s),
                    *self._turns(robot, begun_s, now_s),
                ]
        return [*found, formed]

    def _broken(self, process: Process, before: int, robot: int) -> list[Link]:
        """Why a coordinator had broken its link to a robot."""
        for turn in range(before, -1, -1):
            for command in process.commands(turn, only=Note):
                match command:
                    case Note(LinkBroken(neighbour=other, cause="silence")) if other == robot:
                        return self._unheard(process, robot, addresses.link, turn)
                    case _:
                        pass
        return []

    def _turns(self, robot: int, from_s: float, to_s: float) -> Iterator[Link]:
        """The turns of a robot, and why it found no way."""
        for source, entry in self._lines:
            if not from_s <= entry.t_s <= to_s + LAG_S:
                continue
            match entry.record:
                case FenceChanged(may="one", named=named) if named == robot:
                    yield of_entry(source, entry)
                case RobotBlocked() if source == robot_name(robot):
                    yield of_entry(source, entry)
                case _:
                    pass

    def _fences(self, epoch: int) -> Iterator[tuple[float, FenceChanged]]:
        for _, entry in self._lines:
            if isinstance(entry.record, FenceChanged) and entry.record.epoch == epoch:
                yield entry.t_s, entry.record
