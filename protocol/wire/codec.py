"""Messages as bytes: a msgpack map {v: schema version, n: number, m: message} and its checksum, and back.

Rule 1: for any bytes of a peer, `decode` returns a message or raises `MessageRefusedError`, and nothing else.
Rule 2: our own messages fit into the size limit; a larger one is an error of ours.
Rule 3: the checksum is CRC-32, appended as a msgpack integer of 5 bytes. It refuses messages that were
        damaged on their way, since a flipped bit often gives another valid number. It is no signature:
        passwords authenticate. It covers the key too: one flipped bit turns `r3` into `r2`, and a robot would
        accept another's odometry as its own.
"""

import zlib
from typing import Any

import msgpack
import msgspec

from protocol.errors import UNREADABLE, MessageRefusedError
from protocol.frames import Count
from protocol.wire.messages import Message

SCHEMA_VERSION = 4
SIZE_MAX_BYTES = 65_536  # the largest scan, with 7200 directions, takes 64.9 kB
UINT32 = 0xCE  # msgpack: an integer of 4 bytes, most significant first
SEAL_BYTES = 5
AROUND_BYTES_MAX = 512  # of what surrounds a part of a message that may be large
REASON_LENGTH_MAX = 200  # a reason may quote the peer's text, which can be as long as its message


class _Envelope(msgspec.Struct, frozen=True):
    """The content of a payload."""

    v: int
    n: Count
    m: Message


def packed(value: Any) -> bytes:  # noqa: ANN401 - msgspec's own signature; any of our types
    """One of our types as msgpack."""
    return bytes(msgpack.packb(msgspec.to_builtins(value)))


def fits(part: Any) -> bool:  # noqa: ANN401 - as `packed`
    """Whether a message has room for this part."""
    return len(packed(part)) <= SIZE_MAX_BYTES - AROUND_BYTES_MAX


def sealed(content: bytes, key: str = "") -> bytes:
    """The content, followed by the checksum of content and key."""
    return content + _seal(content, key)


def encode(message: Message, number: int, key: str = "") -> bytes:
    """The bytes of a message with its number on its key; the checksum covers the key if there is one."""
    payload = sealed(packed(_Envelope(SCHEMA_VERSION, number, message)), key)
    assert len(payload) <= SIZE_MAX_BYTES, f"{type(message).__name__} takes {len(payload)} bytes"
    return payload


def decode(payload: bytes, key: str = "") -> tuple[int, Message]:
    """The number and the message in a payload that arrived on this key.

    Raises:
        MessageRefusedError: it is not a message of this schema version, or a field is out of bounds.
    """
    if len(payload) > SIZE_MAX_BYTES:
        raise MessageRefusedError(f"{len(payload)} bytes, more than {SIZE_MAX_BYTES}")
    content = memoryview(payload)[:-SEAL_BYTES]
    if _seal(content, key) != payload[-SEAL_BYTES:]:
        raise MessageRefusedError("its checksum is not that of its content")
    try:
        # msgpack checks array and map lengths against the payload, so a false length cannot claim memory.
        raw = msgpack.unpackb(content)
        if isinstance(raw, dict) and raw.get("v") != SCHEMA_VERSION:
            raise MessageRefusedError(
                f"schema version {raw.get('v')!r}, not {SCHEMA_VERSION}"[:REASON_LENGTH_MAX]
            )
        envelope = msgspec.convert(raw, _Envelope)
    except UNREADABLE as error:
        raise MessageRefusedError(f"{error}"[:REASON_LENGTH_MAX] or type(error).__name__) from error
    return envelope.n, envelope.m


def _seal(content: bytes | memoryview, key: str) -> bytes:
    return b"%c%b" % (UINT32, zlib.crc32(key.encode(), zlib.crc32(content)).to_bytes(4))
