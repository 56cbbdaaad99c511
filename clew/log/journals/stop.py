"""Replays robots up to a moment, or up to the first event after which an expression is true.

Rule 1: new cores get the recorded inputs, as `clew.log.replay` gives them. What is shown is the state of the
        new core; `differs` says whether one of its decisions up to here is not the recorded one.
Rule 2: what a full journal has not kept is refused, not guessed.
"""

from collections import deque
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path

from msgspec.structs import asdict

from agents.process.journal import Decision, Head, Input
from agents.robot import Robot
from clew.log.journals.condition import Condition
from clew.log.journals.recording import Recording
from clew.log.journals.state import NAMES, CoreState, state_of
from clew.log.replay import decide, new_core, nothing_to_replay
from clew.log.replay_missing import journals_in, missing, told
from protocol.errors import UsageError
from protocol.keys import robot_name
from protocol.wire.codec import packed


@dataclass(frozen=True, slots=True)
class Stop:
    """A core right after an input. It goes on when the next one is asked for."""

    core: Robot
    head: Head
    count: int
    """Number of the input, from 1."""
    heard: Input
    decided: Decision
    differs: int | None
    """The first input whose decision is not the recorded one; None: all are the same."""

    @property
    def state(self) -> CoreState:
        """The state of the core."""
        return state_of(self.core, self.count, self.heard, self.head.robot)


def condition(text: str) -> Condition:
    """An expression over the names of a core's state.

    Raises:
        UsageError: it is none.
    """
    return Condition(text, NAMES)


def moments(run: Path, *, until_s: float, robot: int | None) -> list[Stop]:
    """Each robot, or one, after its last input up to then.

    Raises:
        UsageError: there are no inputs of them up to then, or they were not kept.
    """
    newest: dict[int, Stop] = {}
    read: dict[int, Recording] = {}
    for recording in _recordings(run, robot):
        number = recording.head.robot
        for stop in deque(_stops(recording, until_s), maxlen=1):
            if number not in newest or newest[number].heard.now_s <= stop.heard.now_s:
                newest[number], read[number] = stop, recording
    if not newest:
        raise UsageError(f"{run}: no inputs up to t={until_s:g} s")
    _check_kept(run, read.values(), until_s)
    return [newest[number] for number in sorted(newest)]


def first(run: Path, said: Condition, *, until_s: float | None, robot: int | None) -> Stop | None:
    """The first event of all robots, or of one, after which the expression is true; None: it never is.

    Raises:
        UsageError: there are no inputs, or not all were kept before it is true, or the expression compares
            what cannot be.
    """
    found: list[Stop] = []
    recordings = _recordings(run, robot)
    for recording in recordings:
        limit_s = min((each.heard.now_s for each in found), default=until_s)
        hits = (each for each in _stops(recording, limit_s) if said.holds(asdict(each.state)))
        found += [hit for hit in (next(hits, None),) if hit is not None]
    earliest = min(found, key=lambda each: (each.heard.now_s, each.head.robot), default=None)
    _check_kept(run, recordings, until_s if earliest is None else earliest.heard.now_s)
    return earliest


def _check_kept(run: Path, recordings: Iterable[Recording], until_s: float | None) -> None:
    """Rule 2, of journals that were read up to then, or to their ends."""
    for recording in recordings:
        if recording.unkept is not None and (until_s is None or recording.heard_s < until_s):
            raise UsageError(f"{run}: {recording.unkept}")


def gaps(run: Path, robot: int | None) -> list[str]:
    """Which processes of the robots have no journal though they took part, in sentences."""
    heads = [recording.head for recording in _recordings(run, robot)]
    return [told(each) for each in missing(run, heads, robot) or () if each.excuse is None]


def _recordings(run: Path, robot: int | None) -> Sequence[Recording]:
    found = list(journals_in(run, "r*" if robot is None else robot_name(robot)))
    if not found:
        raise nothing_to_replay(run, robot)
    return found


def _stops(recording: Recording, until_s: float | None) -> Iterator[Stop]:
    """The core after each input up to then."""
    head, differs = recording.head, None
    core = new_core(recording.path, head)
    for count, turn in enumerate(recording.turns(), start=1):
        if until_s is not None and turn.input.now_s > until_s:
            return
        decided = decide(core, turn.input)
        if differs is None and turn.decision is not None and packed(decided) != packed(turn.decision):
            differs = count
        yield Stop(core, head, count, turn.input, decided, differs)
        if decided.failed is not None:
            return
