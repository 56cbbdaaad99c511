"""A message on the network of a rehearsal: its key, and the event that it becomes at the receiver."""

from msgspec import Struct
from msgspec.structs import replace

from agents.events import Event as RobotEvent
from agents.events import LinkHeard, OdometryHeard, ScanHeard, ViewHeard
from protocol.faults.damage import Damage
from protocol.fence import Raise, Turn
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

    def to_robot(self) -> RobotEvent | None:
        """The event for a robot; None for messages that robots do not receive."""
        match self.message:
            case Odometry() as odometry:
                return OdometryHeard(odometry)
            case Scan() as scan:
                return ScanHeard(scan)
            case AheadState() | BehindState() as state:
                return LinkHeard(self.sender, self.number, state)
            case Report() | Answer() | Formation() | Plea() as said:
                return ViewHeard(self.sender, self.number, said)
            case _:
                return None

    def to_world(self) -> WorldEvent | None:
        """The event for the world; None for messages that the world does not receive."""
        match self.message:
            case Drive() as drive:
                return OrderHeard(self.sender, drive)
            case Raise() | Turn() as change:
                return FencePut(self.sender, change)
            case ScanQuery(revolutions=revolutions):
                return ScanAsked(self.sender, revolutions)
            case _:
                return None
