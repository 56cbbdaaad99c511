"""Messages as bytes: a msgpack map {v: schema version, n: number, m: message} and its checksum, and back.

Rule 1: whatever a peer sends, `decode` returns a message or raises `MessageRefusedError`; nothing else.
Rule 2: what we send fits; a message that does not is our own fault.
Rule 3: the checksum, CRC-32 as one more msgpack integer of 5 bytes, refuses what was damaged on its way:
        a flipped bit often makes another lawful number. It is no signature, for that there are passwords.
        It covers the key as well, by which the message goes: one bit makes `r2` of `r3`, so that a robot
        would take another's odometry for its own.
"""

import zlib
from typing import Any

import msgpack
import msgspec

from protocol.errors import MessageRefusedError
from protocol.frames import Count
from protocol.wire.messages import Message

SCHEMA_VERSION = 2
SIZE_MAX_BYTES = 65_536  # a scan in 7200 directions, the largest we allow, takes 64.9 kB
UINT32 = 0xCE  # msgpack: an integer of 4 bytes, most significant first
SEAL_BYTES = 5
REASON_LENGTH_MAX = 200  # a reason may quote the peer's text, which may be as long as its message


class _Envelope(msgspec.Struct, frozen=True):
    """What goes over the wire."""

    v: int
    n: Count
    m: Message


def packed(value: Any) -> bytes:  # noqa: ANN401 - msgspec's own signature; any of our types
    """One of our types as msgpack."""
    return bytes(msgpack.packb(msgspec.to_builtins(value)))


def sealed(content: bytes, key: str = "") -> bytes:
    """The content with its checksum, and the key's, behind it."""
    return content + _seal(content, key)


def encode(message: Message, number: int, key: str = "") -> bytes:
    """The bytes of a message and its number on its key; without a key it goes by none."""
    payload = sealed(packed(_Envelope(SCHEMA_VERSION, number, message)), key)
    assert len(payload) <= SIZE_MAX_BYTES, f"{type(message).__name__} takes {len(payload)} bytes"
    return payload


def decode(payload: bytes, key: str = "") -> tuple[int, Message]:
    """The number and the message in a payload that came by this key.

    Raises:
        MessageRefusedError: it is no message of this schema version, or a field is out of bounds.
    """
    if len(payload) > SIZE_MAX_BYTES:
        raise MessageRefusedError(f"{len(payload)} bytes, more than {SIZE_MAX_BYTES}")
    content = memoryview(payload)[:-SEAL_BYTES]
    if _seal(content, key) != payload[-SEAL_BYTES:]:
        raise MessageRefusedError("its checksum is not that of its content")
    try:
        # Its array and map lengths are held to the payload's, so a short lie cannot claim memory.
        raw = msgpack.unpackb(content)
        if isinstance(raw, dict) and raw.get("v") != SCHEMA_VERSION:
            raise MessageRefusedError(
                f"schema version {raw.get('v')!r}, not {SCHEMA_VERSION}"[:REASON_LENGTH_MAX]
            )
        envelope = msgspec.convert(raw, _Envelope)
    except (ValueError, RecursionError) as error:  # msgpack's and msgspec's are ValueErrors
        raise MessageRefusedError(f"{error}"[:REASON_LENGTH_MAX] or type(error).__name__) from error
    return envelope.n, envelope.m


def _seal(content: bytes | memoryview, key: str) -> bytes:
    return b"%c%b" % (UINT32, zlib.crc32(key.encode(), zlib.crc32(content)).to_bytes(4))
