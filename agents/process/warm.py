"""What a host loads and computes once, before it forks its robots: each would do it again.

Without it, a robot takes twice the processor time until it has its mission.
"""

import msgspec

import agents.navigation.guidance  # noqa: F401 - with scipy, so that all robots share it
from protocol.laws import OURS, find
from protocol.network.session import Session
from protocol.wire.codec import decode, encode
from protocol.wire.messages import Ask


def warm_up() -> None:
    """Load our laws and their libraries, and let msgspec read the types of all messages and of a session."""
    for law in OURS:
        find(law)
    decode(encode(Ask(), 0))
    session = Session(fleet="any", run="run", name="r1", endpoints=("tcp/127.0.0.1:7447",))
    msgspec.json.decode(msgspec.json.encode(session), type=Session)
