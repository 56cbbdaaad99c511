"""What any source records of its messages: refused, taken by a fault plan, counted."""

from typing import Annotated

from msgspec import Meta, field

from protocol.frames import Count
from protocol.timeline.base import Counts, Kind, Text


class MessageRefused(Kind, frozen=True, kw_only=True, tag="message.refused"):
    """A message broke the protocol and was dropped."""

    key: Annotated[Text, Meta(description="without the run's root")]
    reason: Text


class FaultInjected(Kind, frozen=True, kw_only=True, tag="fault.injected"):
    """A fault plan has struck: a message, noted by its receiver, or a process."""

    fault: Annotated[Text, Meta(description="`drop`, `delay`, ..., as in the plan; `start` ends a restart")]
    rule: Annotated[Text, Meta(description="the rule's name")]
    key: Annotated[Text | None, Meta(description="of the message, without the run's root")] = None
    number: Annotated[
        Count | None,
        Meta(description="of the message on that key; an answer's, or a query's, is the receiver's count"),
    ] = None
    process: Annotated[Text | None, Meta(description="which was struck: `r3`, `world`, `router`")] = None


class TrafficCounted(Kind, frozen=True, kw_only=True, tag="traffic.counted"):
    """A source's messages by key (without the run's root): sent, received, the newest number that came."""

    sent: Counts
    received: Counts
    newest: Counts
    injected: Annotated[
        dict[Annotated[str, Meta(max_length=40)], Counts],
        Meta(max_length=40, description="by fault, what a fault plan took away, by key: it was not received"),
    ] = field(default_factory=dict)
    refused: Annotated[Counts, Meta(description="by key, what broke the protocol and was dropped")]
    overflowed: Annotated[Count, Meta(description="arrivals that its full inbox dropped")]
    unrecorded: Annotated[Count, Meta(description="entries of its own that its full outbox did not take")]


class RobotSettled(Kind, frozen=True, kw_only=True, tag="robot.settled"):
    """A robot has heard that the run is over and sends no more; `sent` is final."""

    sent: Counts
