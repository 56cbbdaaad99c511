"""Entries of any source about messages: refused, affected by a fault plan, counted."""

from typing import Annotated

from msgspec import Meta, field

from protocol.frames import Count
from protocol.timeline.base import Counts, Kind, Text


class MessageRefused(Kind, frozen=True, kw_only=True, tag="message.refused"):
    """A message broke the protocol and was dropped."""

    key: Annotated[Text, Meta(description="without the run's root")]
    reason: Text


class FaultInjected(Kind, frozen=True, kw_only=True, tag="fault.injected"):
    """A fault was injected into a message (recorded by its receiver) or a process."""

    fault: Annotated[
        Text,
        Meta(
            description="`drop`, `delay`, ..., as in the plan; "
            "`start` ends a restart, `thaw` a freeze, `unslow` a slow"
        ),
    ]
    rule: Annotated[Text, Meta(description="the name of the rule")]
    key: Annotated[Text | None, Meta(description="of the message, without the run's root")] = None
    number: Annotated[
        Count | None,
        Meta(description="of the message on that key; 0: a query or a reply, which have none"),
    ] = None
    process: Annotated[Text | None, Meta(description="the affected process: `r3`, `world`, `router`")] = None


class TrafficCounted(Kind, frozen=True, kw_only=True, tag="traffic.counted"):
    """A source's messages by key (without the run's root): sent, received, and the newest number received.

    Counts of more keys than fit into one message (about 1,300 robots) are told in several entries.
    """

    sent: Counts
    received: Counts
    newest: Counts
    injected: Annotated[
        dict[Annotated[str, Meta(max_length=40)], Counts],
        Meta(
            max_length=40,
            description="by fault and key: messages that a fault removed; not in `received`",
        ),
    ] = field(default_factory=dict)
    refused: Annotated[Counts, Meta(description="by key: messages that broke the protocol and were dropped")]
    overflowed: Annotated[Count, Meta(description="arrivals dropped by its full inbox")]
    unrecorded: Annotated[Count, Meta(description="its own entries refused by its full outbox")]


class RobotSettled(Kind, frozen=True, kw_only=True, tag="robot.settled"):
    """A robot knows that the run is over and sends no more; `sent` is final."""

    sent: Counts
