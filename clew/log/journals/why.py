"""Why an entry came about: the way back from it, over decisions, inputs and messages, to its beginning.

Rule 1: a decision has one cause, found by replays (`clew.log.journals.trials`): the newest input without
        which the core would not have done it.
Rule 2: a message leads to its sender: to the turn in which it first told the values that mattered, since a
        robot tells its whole state again and again.
Rule 3: odometry whose fence mattered leads over the world's `fence.changed` to the robot that put it;
        odometry whose body mattered, to the order that moves that body.
Rule 4: the way ends at a scan, a liveliness token, the start, the operator, or a message that only had to
        come; it says so where a journal is missing.
Rule 5: what no input explains, silence or a place that a robot has not got, is explained as
        `clew.log.journals.explained` says; the way begins there.
Rule 6: where a leader planned a step in a decision, or knew none, the way has what its law could choose from.
Rule 7: a robot watches all tokens because it coordinates a view: that leads to how it joined the view.
"""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from functools import cache
from itertools import count as counted

from agents.commands import AskScan, Command, Note, Order, Put, Say, Tell
from agents.events import LinkHeard, OdometryHeard, ScanHeard, TokensSeen, TokensWatched, ViewHeard
from clew.log.journals.contents import content, does, tag_of
from clew.log.journals.effects import Effects
from clew.log.journals.entries import noted
from clew.log.journals.explained import Explained
from clew.log.journals.links import Link, of_entry
from clew.log.journals.process import Process, message_in, sender_process
from clew.log.journals.trials import Cause, Deed, Trials
from clew.log.law_asked import asked_in, chosen, given
from protocol.faults.message_faults import sender_of
from protocol.fence import Raise, Turn
from protocol.keys import WORLD, robot_name
from protocol.process.tokens import TokenCame, TokenWent
from protocol.timeline import (
    Entry,
    FaultInjected,
    FenceChanged,
    OrderAccepted,
    OrderFinished,
    OrderRefused,
    ScanServed,
    StepFinished,
    ViewJoined,
    kind_of,
)
from protocol.wire.messages import Message, Odometry
from world.record.lines import Line

LINKS_MAX = 200  # far more than any real way has


@dataclass(frozen=True, slots=True)
class _Deed:
    """Something that a core did in a turn."""

    process: Process
    turn: int
    said: str
    is_it: Deed


class Why:
    """The causes of the entries of a run."""

    def __init__(self, processes: list[Process], lines: Sequence[Line]) -> None:
        self._processes, self._lines = processes, lines
        self._trials = cache(Trials)
        self._explained = Explained(processes, lines, self._trials)

    def way(self, index: int) -> list[Link]:
        """The way to an entry, which is the last of it.

        Raises:
            UsageError: this version of a core does not decide as recorded.
        """
        links: list[Link] = [of_entry(*self._lines[index])]
        deed, between = self._deed_of(index)
        links += between
        while deed is not None and len(links) < LINKS_MAX:
            links.append(self._decision(deed))
            links += self._choice(deed)
            if explained := self._explained.of(deed.process, deed.turn, deed.is_it):
                links += explained[::-1]
                break
            cause = self._trials(deed.process).cause(deed.turn, deed.is_it)
            if cause is None:
                links.append(self._start(deed.process))
                break
            links.append(self._input(deed.process, cause))
            deed, between = self._before(deed.process, cause)
            links += between
        return links[::-1]

    def effects(self, index: int) -> list[Link]:
        """What the decision led to that noted an entry, or led to it; none where no core did.

        Raises:
            UsageError: this version of a core does not decide as recorded.
        """
        deed, _ = self._deed_of(index)
        if deed is None:
            return []
        return Effects(self._processes, self._lines, self._trials).of(deed.process, deed.turn)

    # --- entries ------------------------------------------------------------------------------------

    def _deed_of(self, index: int) -> tuple[_Deed | None, list[Link]]:
        """What led to an entry directly."""
        source, entry = self._lines[index]
        found = noted(self._processes, self._lines, index)
        if found is None:
            return self._deed_elsewhere(source, entry)
        note = Note(entry.record)
        said = f"notes {kind_of(entry.record)}"
        return _Deed(found.process, found.turn, said, lambda each: each == note), []

    def _deed_elsewhere(self, source: str, entry: Entry) -> tuple[_Deed | None, list[Link]]:
        """The same for an entry that no core noted."""
        match entry.record:
            case OrderAccepted() | OrderFinished() | OrderRefused() as order:
                return self._ordered(order.robot, order.number, entry.t_s)
            case StepFinished(robot=robot, step=step):
                return self._ordered(robot, None, entry.t_s, step=step)
            case FenceChanged() as fence:
                return self._put(fence, entry.t_s)
            case ScanServed(robot=robot):
                return self._asked(robot, entry.t_s)
            case FaultInjected(key=str(key), number=int(number)):
                return self._sent(source, key, number, entry.t_s)
            case _:
                deadman_s = next((each.head.mission.deadman_s for each in self._processes), 0.0)
                found = self._explained.by_world(entry, deadman_s) if source == WORLD else []
                return None, found[::-1] or [self._end_at(source, entry.t_s)]

    def _end_at(self, source: str, t_s: float) -> Link:
        """No core noted the entry."""
        if source == WORLD:
            return Link(t_s, source, "end", "the world itself recorded it")
        if any(each.name == source for each in self._processes):
            return Link(t_s, source, "end", "the shell of its process recorded it, not its core")
        return Link(t_s, source, "end", "its journal is missing")

    # --- what a core did ----------------------------------------------------------------------------

    def _decision(self, deed: _Deed) -> Link:
        heard = deed.process.turns[deed.turn].input
        return Link(
            heard.now_s, deed.process.name, "decision", deed.said, deed.turn + 1, heard.key, heard.number
        )

    def _choice(self, deed: _Deed) -> Iterator[Link]:
        """Rule 6: of what notes the step, or that there is none, and of the order to drive it."""
        asked = asked_in(deed.process, deed.turn)
        if asked is None or not any(
            isinstance(each, Order) or each == Note(asked)
            for each in deed.process.commands(deed.turn)
            if deed.is_it(each)
        ):
            return
        core = self._trials(deed.process).core_after(deed.turn - 1)
        if (seen := given(core, deed.process, deed.turn)) is not None:
            t_s = deed.process.turns[deed.turn].input.now_s
            yield Link(t_s, deed.process.name, "law", chosen(seen, asked), deed.turn + 1)

    def _start(self, process: Process) -> Link:
        first_s = process.turns[0].input.now_s if process.turns else 0.0
        return Link(first_s, process.name, "start", "its start, its mission and the time led to it", 1)

    def _input(self, process: Process, cause: Cause) -> Link:
        turn = process.turns[cause.turn]
        heard, what = turn.input, "message"
        sender = sender_of(heard.key, process.name)
        match turn.event:
            case OdometryHeard(odometry):
                what, said = "odometry", content(odometry)
            case ScanHeard(scan):
                what, said = "scan", content(scan)
            case LinkHeard(state=message) | ViewHeard(said=message):
                said = f"{sender} told {tag_of(message)}: {content(message)}"
            case TokenCame(robot):
                what, said = "token", f"the token of {_process(robot)} came"
            case TokenWent(robot):
                what, said = "token", f"the token of {_process(robot)} went"
            case TokensSeen(shown):
                what, said = (
                    "token",
                    f"the tokens of {', '.join(_process(robot) for robot, _ in shown)} were there",
                )
            case TokensWatched(robots):
                whose = "all" if robots is None else ", ".join(map(_process, robots)) or "no robot"
                what, said = "token", f"from then on it watched the tokens of {whose}"
        if cause.mattered:
            said += f" [{', '.join(cause.mattered)}]"
        return Link(heard.now_s, process.name, what, said, cause.turn + 1, heard.key, heard.number)

    # --- what came before ---------------------------------------------------------------------------

    def _before(self, process: Process, cause: Cause) -> tuple[_Deed | None, list[Link]]:
        """What led to an input."""
        turn = process.turns[cause.turn]
        heard = turn.input
        match turn.event:
            case OdometryHeard(odometry):
                return self._moved(process, odometry, cause, heard.now_s)
            case LinkHeard() | ViewHeard():
                message = message_in(turn.event)
                assert message is not None, "asked before"
                if not cause.mattered and cause.had_before:
                    return None, [
                        Link(heard.now_s, process.name, "end", "it only mattered that this message came")
                    ]
                return self._told(process, message, cause, (heard.key, heard.number), heard.now_s)
            case TokenWent(robot):
                return None, self._explained.gone(robot, heard.now_s)[::-1]
            case TokensWatched(None):
                return self._coordinated(process, cause.turn), []
            case _:
                return None, []  # a scan, or tokens: the beginning

    def _coordinated(self, process: Process, turn: int) -> _Deed | None:
        """Rule 7: the decision by which a robot began to coordinate, before this turn."""
        for index in reversed(range(turn)):
            for command in process.commands(index, only=Note):
                if isinstance(command, Note) and isinstance(joined := command.record, ViewJoined):
                    return _Deed(
                        process, index, f"notes {kind_of(joined)}", lambda each: each == Note(joined)
                    )
        return None

    def _told(
        self, receiver: Process, message: Message, cause: Cause, place: tuple[str, int], t_s: float
    ) -> tuple[_Deed | None, list[Link]]:
        """Rule 2."""
        key, number = place
        process = sender_process(self._processes, place, t_s, receiver=receiver.name, message=message)
        if process is None:
            sender = sender_of(key, receiver.name)
            return None, [Link(t_s, sender, "end", "the journal of the sender is missing")]

        def is_it(each: Message) -> bool:
            same = all(getattr(each, name) == getattr(message, name) for name in cause.mattered)
            return type(each) is type(message) and same

        first = process.sent[place]
        for earlier in range(number - 1, 0, -1) if cause.mattered else ():
            sent = process.sent[key, earlier]
            if type(sent.message) is type(message):
                if not is_it(sent.message):
                    break
                first = sent
        to = receiver.robot

        def does_it(each: Command) -> bool:
            match each:
                case Tell(robot, said) | Say(robot, said) if robot == to:
                    return is_it(said)
                case _:
                    return False

        return _Deed(process, first.turn, does(process.robot, first.command), does_it), []

    def _moved(
        self, process: Process, odometry: Odometry, cause: Cause, t_s: float
    ) -> tuple[_Deed | None, list[Link]]:
        """Rule 3."""
        if "fence" in cause.mattered or (not cause.mattered and not cause.had_before):
            fence = odometry.fence
            for index, (_, entry) in enumerate(self._lines):
                match entry.record:
                    case FenceChanged(epoch=fence.epoch.number, turn=fence.turn) as changed:
                        deed, links = self._put(changed, entry.t_s)
                        return deed, [of_entry(*self._lines[index]), *links]
                    case _:
                        pass
            return None, [Link(t_s, process.name, "start", "its first odometry")]
        finished = "finished" in cause.mattered
        number = odometry.finished if finished else odometry.ordered
        return self._ordered(process.robot, number, t_s)

    def _ordered(
        self, robot: int, number: int | None, t_s: float, *, step: int | None = None
    ) -> tuple[_Deed | None, list[Link]]:
        """The decision that first gave an order, by its number or its step."""
        for process in self._of(robot, t_s):
            for at in counted(1):
                sent = process.sent.get((f"body/{process.name}/drive", at))
                if sent is None:
                    break
                if isinstance(command := sent.command, Order) and (
                    command.drive.number == number or (step is not None and command.drive.step == step)
                ):
                    drive = command.drive

                    def is_it(
                        each: Command, number: int = drive.number, target: object = drive.target
                    ) -> bool:
                        return isinstance(each, Order) and (each.drive.number, each.drive.target) == (
                            number,
                            target,
                        )

                    return _Deed(process, sent.turn, does(robot, command), is_it), []
        return None, [Link(t_s, robot_name(robot), "end", "no journal has the order of its body")]

    def _put(self, fence: FenceChanged, t_s: float) -> tuple[_Deed | None, list[Link]]:
        """The decision that first put a fence."""
        if fence.coordinator == 0:
            return None, [
                Link(t_s, WORLD, "end", "put by the operator, or by a world that was started again")
            ]
        for process in self._of(fence.coordinator, t_s):
            for at in counted(1):
                sent = process.sent.get((f"body/fence/{process.name}", at))
                if sent is None:
                    break
                match sent.command:
                    case Put(Raise(epoch=epoch) as change) if (epoch.number, 0) == (fence.epoch, fence.turn):
                        pass
                    case Put(Turn(fence=put) as change) if (put.epoch.number, put.turn) == (
                        fence.epoch,
                        fence.turn,
                    ):
                        pass
                    case _:
                        continue

                def is_it(each: Command, change: Raise | Turn = change) -> bool:
                    return each == Put(change)

                return _Deed(process, sent.turn, does(process.robot, sent.command), is_it), []
        return None, [
            Link(t_s, robot_name(fence.coordinator), "end", "no journal has this change of the fence")
        ]

    def _asked(self, robot: int, t_s: float) -> tuple[_Deed | None, list[Link]]:
        """The newest decision by then to ask for a scan."""
        for process in self._of(robot, t_s):
            for turn in range(len(process.turns) - 1, -1, -1):
                if process.turns[turn].input.now_s <= t_s:
                    for command in process.commands(turn, only=AskScan):
                        said = does(robot, command)
                        return _Deed(process, turn, said, lambda each: isinstance(each, AskScan)), []
        return None, [Link(t_s, robot_name(robot), "end", "no journal has the query")]

    def _sent(self, receiver: str, key: str, number: int, t_s: float) -> tuple[_Deed | None, list[Link]]:
        """The decision that sent a message, which a fault has struck."""
        process = sender_process(self._processes, (key, number), t_s, receiver=receiver)
        if process is None:
            sender = sender_of(key, receiver)
            said = "the world keeps no journal" if sender == WORLD else "no journal has this message"
            return None, [Link(t_s, sender, "end", said)]
        sent = process.sent[key, number]
        command = sent.command
        return _Deed(process, sent.turn, does(process.robot, command), lambda each: each == command), []

    def _of(self, robot: int, t_s: float) -> Iterator[Process]:
        """The processes of a robot that had begun by then, newest first."""
        for process in reversed(self._processes):
            if process.robot == robot and process.turns and process.turns[0].input.now_s <= t_s:
                yield process


def _process(robot: int) -> str:
    return WORLD if robot == 0 else robot_name(robot)
