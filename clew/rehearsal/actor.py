"""A process of a rehearsal: a core, the state that a live shell would keep, and the faults it has."""

from collections.abc import Sequence
from dataclasses import dataclass, field

from msgspec import Struct

from agents.commands import Command
from agents.events import Event, OdometryHeard
from agents.process.journal import Given, Journal
from agents.process.points import Points
from agents.robot import Robot
from clew.rehearsal.mail import Mail
from protocol.faults.damage import Damage
from protocol.network.bounded import INBOX_BYTES_MAX, INBOX_CAPACITY, Bounded
from protocol.network.traffic import Traffic
from protocol.wire.messages import Message, Odometry, Phase


class Arrival(Struct, frozen=True, gc=False):
    """Mail that has arrived, perhaps damaged by a fault."""

    mail: Mail
    damage: Damage | None = None


Waiting = Mail | Arrival | Event | Given
"""Mail before the fault plan has decided on it, an arrival, a token event, or input not handled yet."""


@dataclass(slots=True)
class Desk:
    """The connection of the world's process. The bodies go on without it."""

    name: str
    traffic: Traffic = field(default_factory=Traffic)
    ended: bool = False

    def end(self) -> None:
        """Close it: it hears and sends nothing more."""
        self.ended = True


@dataclass(slots=True)
class Actor:
    """A robot's process."""

    robot: int
    name: str
    incarnation: str
    core: Robot
    journal: Journal
    now_s: float = 0.0
    """The time that its core knows."""
    come_s: float = 0.0
    """The newest odometry time that arrived, even if a fault then dropped it. Fault plan and log use it."""
    phase: Phase = Phase.RUNNING
    traffic: Traffic = field(default_factory=Traffic)
    points: Points = field(default_factory=Points)
    ended: bool = False
    frozen: bool = False
    wanted: frozenset[int] | None = frozenset()
    """The robots whose tokens its core wanted to be watched when it was asked last; None: all."""
    delay_s: float = 0.0
    """How long it takes to handle each batch of arrivals (fault `slow`)."""
    busy_until_s: float = 0.0
    unfinished: Sequence[Command] = ()
    """The commands left when it was frozen at a point of its step."""
    is_behind: bool = False
    """Whether something waits until it attends."""
    inbox: Bounded[Waiting] = field(
        default_factory=lambda: Bounded(capacity=INBOX_CAPACITY, bytes_max=INBOX_BYTES_MAX)
    )

    def end(self) -> None:
        """End the process."""
        self.ended = True

    def freeze(self) -> None:
        """Stop it: what arrives waits."""
        self.frozen = True

    def thaw(self) -> None:
        """Let it go on."""
        self.frozen = False

    def want(self, wanted: frozenset[int] | None) -> None:
        """Its core wants these robots' tokens to be watched."""
        self.wanted = wanted

    def slow_down(self, delay_s: float) -> None:
        """From now on it takes this long to handle each batch."""
        self.delay_s = delay_s

    def begin_batch(self, now_s: float) -> None:
        """Begin to handle what has arrived."""
        if self.delay_s > 0.0:
            self.busy_until_s = now_s + self.delay_s

    def leave_unfinished(self, commands: Sequence[Command]) -> None:
        """Keep the commands that a fault has left."""
        self.unfinished = commands
        self.is_behind |= len(commands) > 0

    def take_unfinished(self) -> Sequence[Command]:
        """Remove and return the commands that a fault had left."""
        commands, self.unfinished = self.unfinished, ()
        return commands

    def meet(self, message: Message) -> None:
        """Note the time of a message that has arrived, before the fault plan decides on it."""
        if isinstance(message, Odometry) and message.t_s > self.come_s:
            self.come_s = message.t_s

    def hear_world(self, odometry: Odometry) -> None:
        """Adopt the time and the phase; neither goes back."""
        self.now_s = max(self.now_s, odometry.t_s)
        self.phase = self.phase.later(odometry.phase)

    def is_outdated(self, event: Event) -> bool:
        """Whether this is odometry older than the newest known."""
        return isinstance(event, OdometryHeard) and event.odometry.t_s < self.now_s

    def attends(self, now_s: float) -> bool:
        """Whether it handles what arrives now."""
        return not self.frozen and now_s >= self.busy_until_s

    def wait(self, item: Waiting) -> None:
        """Keep the item until the actor attends. A full inbox drops its oldest items and counts them."""
        self.inbox.append(item, _size_bytes(item))
        self.is_behind = True
        self.traffic.note_overflow(self.inbox.dropped_count)

    def take_waiting(self) -> list[Waiting]:
        """Remove and return all waiting items, in order."""
        self.is_behind = False
        return self.inbox.drain()


def _size_bytes(item: Waiting) -> int:
    """The size of a message on a live network; token events and input that was read before take none."""
    match item:
        case Mail():
            return item.size_bytes
        case Arrival(mail):
            return mail.size_bytes
        case _:
            return 0
