"""What a decision led to: its messages, and what each made its receivers do, and so on.

Rule 1: a receiver did something because of a message if its core would not have done it in that turn without
        the message, found by replay. What it did later is not followed.
Rule 2: at the world the way ends with the entry of the order or of the fence.
"""

from collections import defaultdict, deque
from collections.abc import Callable, Iterator, Sequence

from agents.commands import Command, Note, Order, Put
from clew.log.journals.contents import does
from clew.log.journals.links import Link, of_entry
from clew.log.journals.process import Process, message_in, sender_process
from clew.log.journals.trials import Deed, Trials
from protocol.fence import Raise
from protocol.timeline import FenceChanged, OrderAccepted
from world.record.lines import Line

LINKS_MAX = 200  # enough to read; a fleet goes on because of almost everything


class Effects:
    """The effects of the decisions of a run."""

    def __init__(
        self, processes: Sequence[Process], lines: Sequence[Line], trials: Callable[[Process], Trials]
    ) -> None:
        self._processes, self._lines, self._trials = processes, lines, trials
        self._heard: dict[tuple[str, int], list[tuple[Process, int]]] = defaultdict(list)
        for process in processes:
            for turn, each in enumerate(process.turns):
                if each.input.number > 0:
                    self._heard[each.input.key, each.input.number].append((process, turn))

    def of(self, process: Process, turn: int) -> list[Link]:
        """What the decision of a turn led to, by the order in which it spread."""
        links: list[Link] = []
        seen = {(process, turn)}
        spreading = deque([(process, turn, [*process.commands(turn)])])
        while spreading and len(links) < LINKS_MAX:
            sender, at, commands = spreading.popleft()
            for key, number, command in _sent(sender, at):
                if command not in commands:
                    continue
                links += self._at_world(command, sender.robot, sender.turns[at].input.now_s)
                for receiver, place in self._heard.get((key, number), ()):
                    if (receiver, place) in seen or not self._is_from(sender, receiver, place):
                        continue
                    seen.add((receiver, place))
                    if effects := self._because(receiver, place):
                        links += (_link(receiver, place, each) for each in effects)
                        spreading.append((receiver, place, effects))
        return links[:LINKS_MAX]

    def _is_from(self, sender: Process, receiver: Process, turn: int) -> bool:
        heard, message = receiver.turns[turn].input, message_in(receiver.turns[turn].event)
        place = (heard.key, heard.number)
        by = sender_process(self._processes, place, heard.now_s, receiver=receiver.name, message=message)
        return by is sender

    def _because(self, process: Process, turn: int) -> list[Command]:
        """Rule 1."""
        trials = self._trials(process)
        return [command for command in process.commands(turn) if trials.needs(turn, _is(command))]

    def _at_world(self, command: Command, robot: int, t_s: float) -> Iterator[Link]:
        """Rule 2."""
        for source, entry in self._lines:
            if entry.t_s < t_s or not isinstance(entry.record, OrderAccepted | FenceChanged):
                continue
            if _is_of(entry.record, command, robot):
                yield of_entry(source, entry, "effect")
                return


def _is(command: Command) -> Deed:
    return lambda each: each == command


def _sent(process: Process, turn: int) -> Iterator[tuple[str, int, Command]]:
    for (key, number), sent in process.sent.items():
        if sent.turn == turn:
            yield key, number, sent.command


def _is_of(record: OrderAccepted | FenceChanged, command: Command, robot: int) -> bool:
    """Whether the world recorded this because of the command."""
    match command, record:
        case Order(drive), OrderAccepted(robot=of, number=number):
            return (of, number) == (robot, drive.number)
        case Put(Raise(epoch=epoch)), FenceChanged() as fence:
            return (fence.epoch, fence.turn) == (epoch.number, 0)
        case Put(change), FenceChanged() as fence if not isinstance(change, Raise):
            return (fence.epoch, fence.turn) == (change.fence.epoch.number, change.fence.turn)
        case _:
            return False


def _link(process: Process, turn: int, command: Command) -> Link:
    heard = process.turns[turn].input
    what = "note" if isinstance(command, Note) else "effect"
    said = does(process.robot, command)
    return Link(heard.now_s, process.name, what, said, turn + 1, heard.key, heard.number)
