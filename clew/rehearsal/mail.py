"""A message on the network of a rehearsal, and the event that a message becomes at its receiver."""

from msgspec import Struct
from msgspec.structs import replace

from agents.events import Event as RobotEvent
from agents.events import LinkHeard, OdometryHeard, ScanHeard, ViewHeard
from protocol.faults.damage import Damage
from protocol.fence import Raise, Release, Stop, Turn
from protocol.wire.codec import decode, encode
from protocol.wire.messages import AheadState, BehindState, Drive, Message, Odometry, Scan, ScanQuery
from protocol.wire.view import Answer, Formation, Plea, Report
from world.events import Event as WorldEvent
from world.events import FencePut, OrderHeard, ScanAsked


class Mail(Struct, frozen=True, gc=False):
    """A message in transit to one receiver."""

    sender: int
    receiver: int
    key: str
    """The key without the run's root."""
    number: int
    """The number on that key; 0 for queries and answers, which are not counted."""
    message: Message

    @property
    def kind(self) -> str:
        """The message's tag."""
        return str(self.message.__struct_config__.tag)

    @property
    def size_bytes(self) -> int:
        """What it takes on a live network."""
        return len(self.key) + len(encode(self.message, self.number, self.key))

    def damaged(self, damage: Damage) -> "Mail":
        """The mail decoded after damage in transit.

        Raises:
            MessageRefusedError: the codec has detected the damage, as it should.
        """
        number, message = decode(damage.apply(encode(self.message, self.number)))
        return replace(self, number=number, message=message)


def event_for_robot(message: Message, sender: int, number: int) -> RobotEvent | None:
    """The event for a robot; None for messages that robots do not receive."""
    match message:
        case Odometry():
            return OdometryHeard(message)
        case Scan():
            return ScanHeard(message)
        case AheadState() | BehindState():
            return LinkHeard(sender, number, message)
        case Report() | Answer() | Formation() | Plea():
            return ViewHeard(sender, number, message)
        case _:
            return None


def event_for_world(message: Message, sender: int) -> WorldEvent | None:
    """The event for the world; None for messages that the world does not receive."""
    match message:
        case Drive():
            return OrderHeard(sender, message)
        case Raise() | Turn() | Stop() | Release():
            return FencePut(sender, message)
        case ScanQuery(revolutions=revolutions):
            return ScanAsked(sender, revolutions)
        case _:
            return None
