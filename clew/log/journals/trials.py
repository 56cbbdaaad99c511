"""What a robot's core would have done without some inputs: replays of one process with inputs silenced.

Rule 1: a silenced message, scan or token event is as if it had not come. Silenced odometry still tells the
        time, and nothing else that is new: body, fence and phase are those of the last one before.
Rule 2: the cause of what a core did in a turn is the newest input without which it would not have done it:
        with that input and all after it silenced it does not, with only those after it silenced it does.
Rule 3: of that input, a field has mattered if the core would not have done it with the value that the sender
        had told before.
"""

import copy
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property

from msgspec.structs import replace

from agents.commands import Command
from agents.events import Event, LinkHeard, OdometryHeard, TokensSeen, ViewHeard
from agents.robot import Robot
from clew.log.journals.process import Process, message_in
from clew.log.replay import decide, new_core
from protocol.errors import UsageError
from protocol.wire.codec import packed

Deed = Callable[[Command], bool]
"""Whether a command is what was done."""

STRIDE = 32  # turns between two copies of a core: a copy takes as long as some 15 turns
NOTHING = TokensSeen(())
"""An event without content: time goes on."""
TIMES = ("t_s", "n", "number", "life", "epoch")
"""The fields of messages that every message has anew, or that say whose it is."""


@dataclass(frozen=True, slots=True)
class Cause:
    """The input that made a core do something."""

    turn: int
    """Index of the input's turn."""
    mattered: tuple[str, ...]
    """The fields of its message that mattered, by themselves; empty: all of them together, or it has none."""
    had_before: bool
    """Whether the process had such a message from this sender before."""


class Trials:
    """Replays of one process.

    Raises:
        UsageError: this version of the core does not decide as recorded, or its law is not here.
    """

    def __init__(self, process: Process) -> None:
        self._turns = process.turns
        self._cores: dict[int, Robot] = {}
        core = new_core(process.path, process.head)
        for index, turn in enumerate(self._turns):
            if index % STRIDE == 0:
                self._cores[index] = copy.deepcopy(core)
            if turn.decision is not None and packed(decide(core, turn.input)) != packed(turn.decision):
                raise UsageError(
                    f"robot {process.robot}: from input {index + 1} at t={turn.input.now_s:.3f} s on, it"
                    " decides otherwise than recorded (`clew replay` shows it): this version cannot say why"
                )

    def core_after(self, turn: int) -> Robot:
        """A core as it was after this turn."""
        at = turn // STRIDE * STRIDE
        core = copy.deepcopy(self._cores[at])
        for each in self._turns[at : turn + 1]:
            core.handle(each.event, each.input.now_s)
        return core

    def needs(self, turn: int, deed: Deed) -> bool:
        """Whether the core would not have done it in this turn without the input of this turn."""
        return not self._is_done(turn, deed, turn)

    def cause(self, turn: int, deed: Deed) -> Cause | None:
        """Rules 2 and 3; None: nothing but its start and the time."""
        step, known = 1, turn + 1  # with all from `known` on silenced it is done
        while True:
            first = max(0, turn + 1 - step)
            if not self._is_done(turn, deed, first):
                break
            if first == 0:
                return None
            step, known = 2 * step, first
        while known - first > 1:  # silenced from `first` on it is not done
            middle = (first + known) // 2
            if self._is_done(turn, deed, middle):
                known = middle
            else:
                first = middle
        mattered = tuple(self._mattering(turn, deed, first))
        return Cause(first, mattered, had_before=self._before[first] is not None)

    def _mattering(self, turn: int, deed: Deed, cause: int) -> Iterator[str]:
        event = self._turns[cause].event
        before = self._before[cause]
        if before is None or (message := message_in(event)) is None:
            return
        told = message_in(self._turns[before].event)
        for name in message.__struct_fields__:
            if name not in TIMES and getattr(message, name) != getattr(told, name):
                changed = _with(event, replace(message, **{name: getattr(told, name)}))
                if not self._is_done(turn, deed, cause + 1, {cause: changed}):
                    yield name

    def _is_done(
        self, turn: int, deed: Deed, silent_from: int, changed: Mapping[int, Event] | None = None
    ) -> bool:
        """Whether the core does it in this turn, with these inputs changed and the later ones silenced."""
        changed = changed or {}
        first = min((silent_from, *changed, turn))
        at = first // STRIDE * STRIDE
        core = copy.deepcopy(self._cores[at])
        try:
            commands: Sequence[Command] = ()
            body: Event | None = None
            for index in range(at, turn + 1):
                heard, event = self._turns[index].input, changed.get(index, self._turns[index].event)
                if index >= silent_from:
                    event = self._silenced(index, silent_from, body)
                elif isinstance(event, OdometryHeard):
                    body = event
                commands = core.handle(event, heard.now_s)
        except Exception:  # an input that cannot be without the one that is left out
            return False
        return any(map(deed, commands))

    def _silenced(self, index: int, silent_from: int, body: Event | None) -> Event:
        """Rule 1."""
        event = self._turns[index].event
        if not isinstance(event, OdometryHeard):
            return NOTHING
        if body is None:
            earlier = (each.event for each in reversed(self._turns[:silent_from]))
            body = next((each for each in earlier if isinstance(each, OdometryHeard)), None)
        if not isinstance(body, OdometryHeard):
            return NOTHING
        return OdometryHeard(replace(body.odometry, t_s=event.odometry.t_s, n=event.odometry.n))

    @cached_property
    def _before(self) -> list[int | None]:
        """For each turn, the turn before with a message of the same sender and kind."""
        newest: dict[tuple[str, type], int] = {}
        before: list[int | None] = []
        for index, turn in enumerate(self._turns):
            place = (turn.input.key, type(message_in(turn.event)))
            before.append(newest.get(place))
            newest[place] = index
        return before


def _with(event: Event, message: object) -> Event:
    """The event with another message."""
    match event:
        case OdometryHeard():
            return replace(event, odometry=message)
        case LinkHeard():
            return replace(event, state=message)
        case ViewHeard():
            return replace(event, said=message)
        case _:
            return event
