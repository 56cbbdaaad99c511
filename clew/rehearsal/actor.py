"""A process of a rehearsal: a core, what the shell of a live one remembers, and what it suffers."""

from collections import deque
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
from protocol.network.inbox import INBOX_CAPACITY
from protocol.network.traffic import Traffic
from protocol.wire.messages import Message, Odometry, Phase


class Arrival(Struct, frozen=True):
    """Mail that has arrived; a fault plan may have damaged it."""

    mail: Mail
    damage: Damage | None = None


Waiting = Mail | Arrival | Event | Given
"""Mail that the fault plan has not seen, an arrival, a token; or what it has read and not handled yet."""


@dataclass(slots=True)
class Desk:
    """Where the world's process hears and speaks; what its bodies do goes on without it."""

    name: str
    traffic: Traffic = field(default_factory=Traffic)
    ended: bool = False


@dataclass(slots=True)
class Actor:
    """A robot's process."""

    robot: int
    name: str
    incarnation: str
    core: Robot
    journal: Journal
    now_s: float = 0.0
    """What its core knows."""
    come_s: float = 0.0
    """The newest time that has come, whatever became of the odometry: for the fault plan, and the log."""
    phase: Phase = Phase.RUNNING
    traffic: Traffic = field(default_factory=Traffic)
    points: Points = field(default_factory=Points)
    ended: bool = False
    frozen: bool = False
    delay_s: float = 0.0
    """How long it takes over all that has arrived, each time that it looks."""
    busy_until_s: float = 0.0
    unfinished: Sequence[Command] = ()
    """What it was about to do when it was frozen at a point of its step."""
    inbox: deque[Waiting] = field(default_factory=deque)

    def meet(self, message: Message) -> None:
        """A message has come, and nothing has become of it yet."""
        if isinstance(message, Odometry):
            self.come_s = max(self.come_s, message.t_s)

    def hear_world(self, odometry: Odometry) -> None:
        """Take in the time and the phase; neither ever goes back."""
        self.now_s = max(self.now_s, odometry.t_s)
        self.phase = self.phase.later(odometry.phase)

    def is_outdated(self, event: Event) -> bool:
        """Whether this is odometry, and newer is known."""
        return isinstance(event, OdometryHeard) and event.odometry.t_s < self.now_s

    def attends(self, now_s: float) -> bool:
        """Whether it handles what arrives now."""
        return not self.frozen and now_s >= self.busy_until_s

    def wait(self, item: Waiting) -> None:
        """Keep for when it attends; what is full drops the oldest, and counts it."""
        if len(self.inbox) == INBOX_CAPACITY:
            self.inbox.popleft()
            self.traffic.overflowed_count += 1
        self.inbox.append(item)

    def take_waiting(self) -> list[Waiting]:
        """All that has waited, in order."""
        items = list(self.inbox)
        self.inbox.clear()
        return items
