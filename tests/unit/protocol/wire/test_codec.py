"""Messages as bytes: our messages survive a round trip, and invalid bytes of a peer are refused."""

import copy
import math
import zlib
from collections.abc import Iterator
from typing import Any

import msgpack
import pytest
from hypothesis import given
from hypothesis import strategies as st

from protocol.errors import MessageRefusedError
from protocol.fence import GENERATIONS_MAX, Epoch, Fence, May
from protocol.frames import ROBOTS_MAX, Pose
from protocol.timeline import Entry, RouteLost, StrandJoined
from protocol.wire.codec import SCHEMA_VERSION, SEAL_BYTES, SIZE_MAX_BYTES, decode, encode, sealed
from protocol.wire.messages import Ask, LogBatch, Message, Scan
from protocol.wire.view import Answer, Formation, Join
from tests.support.strategies.message_strategies import MESSAGE_TYPES, messages, values_of

NUMBERS = st.integers(0, 2**53)
WRONG = [
    math.nan,
    math.inf,
    -math.inf,
    -1,
    2**64 - 1,
    1e300,
    "",
    "x" * 5000,
    b"\xff",
    None,
    [],
    [[]],
    {},
    True,
]
Unpacked = Any  # the result of unpacking a payload
Path = tuple[str | int, ...]


def paths(value: Unpacked, path: Path = ()) -> Iterator[Path]:
    """The path to every part of an unpacked message."""
    yield path
    if isinstance(value, dict | list):
        for key in value if isinstance(value, dict) else range(len(value)):
            yield from paths(value[key], (*path, key))


def unpacked(message: Message) -> Unpacked:
    return msgpack.unpackb(encode(message, 1)[:-SEAL_BYTES])


def at(value: Unpacked, path: Path) -> Unpacked:
    for key in path:
        value = value[key]
    return value


def with_part(value: Unpacked, path: Path, part: Unpacked) -> bytes:
    changed = copy.deepcopy(value)
    if not path:
        return sealed(msgpack.packb(part))
    at(changed, path[:-1])[path[-1]] = part
    return sealed(msgpack.packb(changed))


def refused_or_lawful(payload: bytes) -> bool:
    """Whether it was refused; an accepted message must be one that we could have sent."""
    try:
        number, message = decode(payload)
    except MessageRefusedError as error:
        return len(str(error)) > 0
    assert decode(encode(message, number)) == (number, message)
    return False


@pytest.mark.parametrize("kind", MESSAGE_TYPES, ids=lambda kind: str(kind.__name__))
@given(data=st.data(), number=NUMBERS)
def test_every_type_of_message_survives_a_round_trip(
    kind: type[Message], data: st.DataObject, number: int
) -> None:
    message = data.draw(values_of(kind))
    assert decode(encode(message, number)) == (number, message)


def test_any_reader_of_msgpack_can_read_the_wire() -> None:
    reader = msgpack.Unpacker()
    reader.feed(payload := encode(Ask(), 3))
    content, checksum = reader
    assert content == {"v": SCHEMA_VERSION, "n": 3, "m": {"type": "ask"}}
    assert checksum == zlib.crc32(payload[:-SEAL_BYTES])


@given(st.binary(max_size=400))
def test_random_bytes_are_refused(payload: bytes) -> None:
    for each in (payload, sealed(payload)):
        with pytest.raises(MessageRefusedError):
            decode(each)


@given(messages(), st.data())
def test_a_message_changed_before_its_checksum_is_refused_or_valid(
    message: Message, data: st.DataObject
) -> None:
    content = encode(message, 1)[:-SEAL_BYTES]
    start = data.draw(st.integers(0, len(content)))
    end = data.draw(st.integers(start, min(len(content), start + 8)))
    refused_or_lawful(sealed(content[:start] + data.draw(st.binary(max_size=8)) + content[end:]))


@given(messages(), st.data())
def test_a_message_with_a_flipped_bit_or_a_missing_end_is_refused(
    message: Message, data: st.DataObject
) -> None:
    payload = bytearray(encode(message, 1))
    bit = data.draw(st.integers(0, 8 * len(payload) - 1))
    payload[bit // 8] ^= 1 << bit % 8
    with pytest.raises(MessageRefusedError, match="checksum"):
        decode(bytes(payload))
    with pytest.raises(MessageRefusedError):
        decode(encode(message, 1)[: bit // 8])


@given(messages())
def test_a_message_that_arrives_on_another_key_is_refused(message: Message) -> None:
    payload = encode(message, 1, "body/r3/odometry")
    assert decode(payload, "body/r3/odometry") == (1, message)
    with pytest.raises(MessageRefusedError, match="checksum"):
        decode(payload, "body/r2/odometry")  # one bit of the key differs


@given(messages(), st.data())
def test_a_message_with_any_part_replaced_is_refused_or_valid(message: Message, data: st.DataObject) -> None:
    raw = unpacked(message)
    path = data.draw(st.sampled_from(list(paths(raw))))
    refused_or_lawful(with_part(raw, path, data.draw(st.sampled_from(WRONG))))


@given(messages(), st.sampled_from([math.nan, math.inf, -math.inf, 1e12, "1.0", {}, []]))
def test_numbers_that_are_nan_infinite_out_of_bounds_or_of_another_type_are_refused(
    message: Message, wrong: object
) -> None:
    raw = unpacked(message)
    for path in paths(raw):
        if isinstance(at(raw, path), float):
            with pytest.raises(MessageRefusedError):
                decode(with_part(raw, path, wrong))


@given(messages(), st.data())
def test_a_message_without_one_of_its_fields_is_refused_or_valid(
    message: Message, data: st.DataObject
) -> None:
    raw = unpacked(message)
    fields = [path for path in paths(raw) if path and isinstance(path[-1], str)]
    path = data.draw(st.sampled_from(fields))
    del at(raw, path[:-1])[path[-1]]
    refused_or_lawful(sealed(msgpack.packb(raw)))


@pytest.mark.parametrize(("rank", "members"), [(ROBOTS_MAX + 1, 1), (0, ROBOTS_MAX + 1)])
def test_a_rank_or_a_number_of_members_that_no_fleet_has_is_refused(rank: int, members: int) -> None:
    """Its reader lists so many robots: such an entry ended the world, and each that was started again."""
    joined = Entry(n=1, t_s=0.0, hlc="", record=StrandJoined(epoch=1, rank=rank, members=members))
    told = Formation(
        epoch=Epoch(),
        life=1,
        turn=1,
        members=members,
        rank=rank,
        s_m=0.0,
        place=Pose(x_m=0.0, y_m=0.0, heading_rad=0.0),
        ahead=None,
        behind=None,
        leg_is_driven=False,
        first=0,
        vertices=0,
        path=(),
    )
    for message in (LogBatch(entries=(joined,)), told):
        with pytest.raises(MessageRefusedError, match=f"<= {ROBOTS_MAX}"):
            decode(encode(message, 1))


def test_a_strand_of_nobody_that_a_robot_is_to_join_is_refused() -> None:
    """It looks for a place behind the last one: such an answer ended the process of a robot in its turn."""
    join = Join(turn=1, strand=(), waiting=(), robots=(), line=(), last_leg=0)
    with pytest.raises(MessageRefusedError, match="length >= 1"):
        decode(encode(Answer(epoch=Epoch(), life=1, heard=1, join=join), 1))


@pytest.mark.parametrize("part", ["v", "n", "m"])
def test_an_envelope_without_one_of_its_parts_is_refused(part: str) -> None:
    raw = unpacked(Ask())
    del raw[part]
    with pytest.raises(MessageRefusedError):
        decode(sealed(msgpack.packb(raw)))


@pytest.mark.parametrize("version", [0, SCHEMA_VERSION + 1, -1, "1", None, [1] * 9000])
def test_another_schema_version_is_refused_with_that_reason(version: object) -> None:
    with pytest.raises(MessageRefusedError, match="schema version"):
        decode(sealed(msgpack.packb({"v": version, "n": 1, "m": {"type": "ask"}})))


@pytest.mark.parametrize(
    "payload",
    [
        b"",
        encode(Ask(), 1) + b"\xc0",
        encode(Ask(), 1)[:-1],
        b"\x91" * 60_000,
        b"\x81\xa1v" * 20_000,
        b"\x81\xa1v" + b"\x91" * 1_000 + b"\x90",  # it can be unpacked, but not printed
        b"\xdd\xff\xff\xff\xff",
        b"\xdf\xff\xff\xff\xff",
        b"\xdb\xff\xff\xff\xff",
        b"\xc9\xff\xff\xff\xff\x05",
        b"\x81\x81\xc0\xc0\xc0",
        b"\x81\xa1\xff\xc0",
        msgpack.packb({"v": SCHEMA_VERSION, "n": 1, "m": msgpack.ExtType(5, b"x")}),
        msgpack.packb({"v": SCHEMA_VERSION, "n": 1, "m": {"type": "x" * 60_000}}),
    ],
    ids=[
        "empty",
        "trailing",
        "cut",
        "deep-lists",
        "deep-maps",
        "deep-version",
        "array-lie",
        "map-lie",
        "string-lie",
        "ext-lie",
        "map-as-key",
        "bad-utf8",
        "extension",
        "huge-tag",
    ],
)
def test_a_malicious_payload_is_refused_with_a_short_reason(payload: bytes) -> None:
    with pytest.raises(MessageRefusedError) as refusal:
        decode(payload)
    assert 0 < len(str(refusal.value)) <= 200
    with pytest.raises(MessageRefusedError) as refusal:
        decode(sealed(payload))
    assert 0 < len(str(refusal.value)) <= 200


def test_the_size_limit_accepts_the_largest_scan_and_no_byte_more_than_the_limit() -> None:
    pose = Pose(x_m=-1e6, y_m=1e6, heading_rad=-math.pi)
    fence = Fence(
        epoch=Epoch(generation=GENERATIONS_MAX, robot=ROBOTS_MAX, life=2**63 - 1),
        turn=2**53,
        may=May.STOPPED,
        robot=ROBOTS_MAX,
        life=2**63 - 1,
        members=ROBOTS_MAX,
    )
    scan = Scan(t_s=1e9, pose=pose, fence=fence, ranges_m=(math.pi,) * 7200)
    assert decode(encode(scan, 2**53)) == (2**53, scan)
    with pytest.raises(MessageRefusedError, match="65537 bytes"):
        decode(b"\xc0" * (SIZE_MAX_BYTES + 1))


def test_sending_more_than_the_limit_fails_an_assertion() -> None:
    lost = RouteLost(reason="x" * 2000)
    entries = tuple(Entry(n=n, t_s=0.0, hlc="", record=lost) for n in range(1, 41))
    with pytest.raises(AssertionError, match="LogBatch takes"):
        encode(LogBatch(entries=entries), 1)
