"""What became of messages: those that faults took, and the books that a link's two robots close with. Pure.

Rule 1: a message is lost at the robot that was to hear it, and an order that the world was to hear at the
        robot that gave it. Only what a fault plan takes away is known before the books are balanced.
Rule 2: a robot that was started again counted in its last life only, and its neighbours in all of its lives.
        So what it counted is not known; nor what a robot counted that never closed its books.
"""

from collections import Counter
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field

from protocol.keys import ends_of, robot_number
from protocol.timeline import Entry, FaultInjected, RobotRestarted, RobotSettled, TrafficCounted
from world.judge.books import TAKES_AWAY

KINDS = frozenset({FaultInjected, RobotRestarted, RobotSettled, TrafficCounted})

Link = tuple[int, int]
"""The robot that sends, and the one that hears."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Book:
    """The messages of a link."""

    sender: int
    receiver: int
    sent: int | None
    """None: not known, rule 2."""
    received: int | None
    injected: int
    """What faults took, by the receiver's count."""


@dataclass(slots=True)
class Losses:
    """What has been lost so far."""

    taken: list[tuple[float, Link]] = field(default_factory=list)
    """Of each message of a link that a fault took: when, and which link's."""
    by_robot: Counter[int] = field(default_factory=Counter)
    """Rule 1."""
    closed: int = 0
    """How many books have been closed."""
    _sent: dict[Link, int] = field(default_factory=dict)
    _received: dict[Link, int] = field(default_factory=dict)
    _injected: Counter[Link] = field(default_factory=Counter)
    _settled: set[int] = field(default_factory=set)
    _counted: set[int] = field(default_factory=set)
    _restarted: set[int] = field(default_factory=set)

    def hear(self, source: str, entry: Entry) -> None:
        """Take an entry in."""
        match entry.record:
            case FaultInjected() as fault:
                if fault.key is not None and fault.fault in TAKES_AWAY:
                    self._take(entry.t_s, fault.key)
            case RobotRestarted(robot=robot):
                self._restarted.add(robot)
                self.closed += 1
            case RobotSettled(sent=sent):
                self._settled.add(robot_number(source) or 0)
                self._sent.update(_of_links(sent))
                self.closed += 1
            case TrafficCounted(received=received, injected=injected):
                self._counted.add(robot_number(source) or 0)
                self._received.update(_of_links(received))
                for counts in injected.values():
                    self._injected.update(dict(_of_links(counts)))
                self.closed += 1
            case _:
                pass  # nothing of messages

    def _take(self, t_s: float, key: str) -> None:
        if (link := link_of(key)) is not None:
            self.taken.append((t_s, link))
        if (robot := _loser(key)) is not None:
            self.by_robot[robot] += 1

    def books(self) -> tuple[Book, ...]:
        """Of each link on which a message was counted, in the order of its robots."""
        told = self._settled - self._restarted, self._counted - self._restarted
        links = sorted({*self._sent, *self._received, *self._injected})
        return tuple(
            Book(
                sender=link[0],
                receiver=link[1],
                sent=self._sent.get(link, 0) if link[0] in told[0] else None,
                received=self._received.get(link, 0) if link[1] in told[1] else None,
                injected=self._injected[link],
            )
            for link in links
        )


def _loser(key: str) -> int | None:
    """Rule 1."""
    sender, receiver = ends_of(key) or ("", "")
    return robot_number(receiver) or robot_number(sender)


def link_of(key: str) -> Link | None:
    """The link that a key, without the run's root, is of."""
    sender, receiver = map(robot_number, ends_of(key) or ("", ""))
    if sender is None or receiver is None or not key.startswith("link/"):
        return None
    return sender, receiver


def _of_links(counts: Mapping[str, int]) -> Iterator[tuple[Link, int]]:
    for key, count in counts.items():
        if (link := link_of(key)) is not None:
            yield link, count
