"""Why a process did not hear another: what became of the messages, and of the two processes.

Rule 1: silence begins with the last message of the speaker that the listener took in, and ends with the
        decision that noticed it. What faults did to messages on these keys meanwhile is told by rule, with
        the numbers of the messages.
Rule 2: what was done to a process counts if it still lasted, or ended in that time. A death that nobody asked
        for is told by when the world last heard the robot.
Rule 3: where neither is known, the speaker's journal says what it sent meanwhile.
"""

from collections import defaultdict
from collections.abc import Collection, Iterable, Iterator, Sequence

from clew.log.journals.contents import content, tag_of
from clew.log.journals.fate import Fate
from clew.log.journals.links import Link, of_entry
from clew.log.journals.messages import FATES
from clew.log.journals.process import Process, message_in
from protocol.keys import robot_name
from protocol.plain import plain
from protocol.timeline import (
    FaultInjected,
    MessageRefused,
    RobotDied,
    RobotFailed,
    RouterFound,
    RouterLost,
)
from protocol.timeline.sentences import sentence
from world.record.lines import Line

DONE = {"kill": "was killed", "freeze": "was frozen", "slow": "was slowed down"}
"""What faults do to a process; any other of a process ends it again."""


class Silence:
    """What a run's log and journals know of silences."""

    def __init__(self, processes: Sequence[Process], lines: Sequence[Line]) -> None:
        self._processes, self._lines = processes, lines

    def heard(self, listener: Process, keys: Collection[str], before: int) -> Link | None:
        """The last message on these keys that a robot took in before a turn."""
        for index in range(before - 1, -1, -1):
            turn = listener.turns[index]
            message = message_in(turn.event)
            if turn.input.key in keys and message is not None:
                said = f"the last of {turn.input.key} that it heard: {tag_of(message)}: {content(message)}"
                place = (turn.input.key, turn.input.number)
                return Link(turn.input.now_s, listener.name, "message", said, index + 1, *place)
        return None

    def between(
        self, listener: str, speaker: int, keys: Collection[str], from_s: float, to_s: float
    ) -> list[Link]:
        """What kept the speaker's messages from the listener in this time; empty: nothing is known."""
        name = robot_name(speaker)
        found = [
            *self._lost(listener, name, keys, from_s, to_s),
            *self.struck(name, from_s, to_s),
            *self.struck(listener, from_s, to_s),
            *self._unrouted(from_s, to_s),
        ]
        return sorted(found or self._sent(name, keys, from_s, to_s), key=lambda link: link.t_s)

    def struck(self, name: str, from_s: float, to_s: float) -> Iterator[Link]:
        """Rule 2: what was done to a process."""
        lasting: Link | None = None
        for source, entry in self._lines:
            match entry.record:
                case FaultInjected(process=struck, fault=fault, rule=rule) if struck == name:
                    if entry.t_s > to_s:
                        break
                    if fault in DONE:
                        lasting = Link(entry.t_s, name, "fault", f"{name} {DONE[fault]} by rule {rule}")
                    elif entry.t_s <= from_s:
                        lasting = None
                case RobotFailed() if source == name and from_s <= entry.t_s <= to_s:
                    lasting = Link(entry.t_s, name, "fault", plain(sentence(source, entry.record)))
                case RobotDied(robot=robot, silent_since_s=since_s) if robot_name(robot) == name:
                    if lasting is None and from_s - 1.0 <= since_s <= to_s:
                        lasting = Link(since_s, name, "fault", f"{name} was dead since t={since_s:.3f} s")
                case _:
                    pass
        if lasting is not None:
            yield lasting

    def _lost(
        self, listener: str, speaker: str, keys: Collection[str], from_s: float, to_s: float
    ) -> Iterator[Link]:
        """Rule 1."""
        struck: dict[tuple[Fate, str], list[tuple[float, int]]] = defaultdict(list)
        for source, entry in self._lines:
            if source != listener or not from_s <= entry.t_s <= to_s:
                continue
            match entry.record:
                case FaultInjected(key=key, fault=fault, rule=rule, number=number) if key in keys:
                    fate = FATES.get(fault, Fate.DELIVERED)
                    if fate not in {Fate.DELIVERED, Fate.DUPLICATED}:
                        struck[fate, f"by rule {rule}"].append((entry.t_s, number or 0))
                case MessageRefused(key=key, reason=reason) if key in keys:
                    struck[Fate.REFUSED, f"since {reason}"].append((entry.t_s, 0))
                case _:
                    pass
        if any(fate is Fate.DAMAGED for fate, _ in struck):  # they were refused for that
            struck = {place: found for place, found in struck.items() if place[0] is not Fate.REFUSED}
        for (fate, how), found in struck.items():
            messages = _messages(number for _, number in found)
            yield Link(found[0][0], listener, "loss", f"then nothing from {speaker}: {messages} {fate} {how}")

    def _unrouted(self, from_s: float, to_s: float) -> Iterator[Link]:
        for source, entry in self._lines:
            if isinstance(entry.record, RouterLost | RouterFound) and from_s <= entry.t_s <= to_s:
                yield of_entry(source, entry)

    def _sent(self, speaker: str, keys: Collection[str], from_s: float, to_s: float) -> Iterator[Link]:
        """Rule 3."""
        found = [each for each in self._processes if each.name == speaker]
        sent = [
            (each.t_s, number)
            for process in found
            for (key, number), each in process.sent.items()
            if key in keys and from_s < each.t_s <= to_s
        ]
        if not found:
            yield Link(to_s, speaker, "end", "the journal of the sender is missing")
        elif sent:
            numbers = _messages(number for _, number in sent)
            said = f"it sent {numbers} meanwhile, and the log does not say what became of them"
            yield Link(sent[0][0], speaker, "loss", said)
        else:
            yield Link(from_s, speaker, "loss", f"it sent nothing more by t={to_s:.3f} s")


def _messages(numbers: Iterable[int]) -> str:
    """`message 4`, `messages 4-9, 11`; those without numbers are counted."""
    found = sorted(numbers)
    known = sorted({each for each in found if each})
    if not known:
        return "1 message" if len(found) == 1 else f"{len(found)} messages"
    ranges: list[list[int]] = []
    for number in known:
        if ranges and ranges[-1][1] == number - 1:
            ranges[-1][1] = number
        else:
            ranges.append([number, number])
    told = ", ".join(str(first) if first == last else f"{first}-{last}" for first, last in ranges)
    return f"message{'s' if len(known) > 1 else ''} {told}"
