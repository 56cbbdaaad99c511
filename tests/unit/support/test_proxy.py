"""The proxy of the packet tests does what it is asked for, and nothing else."""

import asyncio
from collections.abc import AsyncIterator
from contextlib import asynccontextmanager
from random import Random
from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st

from protocol.wire.codec import SEAL_BYTES, sealed
from tests.support.deadline import DEADLINE_S
from tests.support.processes.proxy import FRAME, PIECE_BYTES_MAX, Fate, Faults, Proxy, Way, fate, proxy

PIECES = st.binary(min_size=1, max_size=64)
SEEDS = st.integers(min_value=0, max_value=2**32)
LONG = bytes(range(256)) * 2000

Streams = tuple[asyncio.StreamReader, asyncio.StreamWriter]


async def echo(reader: asyncio.StreamReader, writer: asyncio.StreamWriter) -> None:
    """A server that says whatever it is told."""
    try:
        while said := await reader.read(PIECE_BYTES_MAX):
            writer.write(said)
            await writer.drain()
    except ConnectionError:
        pass  # what some tests want
    finally:
        writer.close()


@asynccontextmanager
async def through_proxy(seed: int = 1) -> AsyncIterator[tuple[Proxy, Streams]]:
    """A client whose way to an echo leads through a proxy."""
    server = await asyncio.start_server(echo, "127.0.0.1", 0)
    async with (
        asyncio.timeout(DEADLINE_S),
        server,
        proxy(server.sockets[0].getsockname()[1], seed=seed) as (between, port),
    ):
        reader, writer = await asyncio.open_connection("127.0.0.1", port)
        try:
            yield between, (reader, writer)
        finally:
            writer.close()


async def answer(streams: Streams, said: bytes) -> bytes:
    """What comes back for what is said."""
    reader, writer = streams
    writer.write(said)
    return await reader.readexactly(len(said))


def differing_bits(one: bytes, other: bytes) -> int:
    assert len(one) == len(other)
    return sum((a ^ b).bit_count() for a, b in zip(one, other, strict=True))


@given(PIECES, SEEDS)
def test_without_faults_a_piece_stays_what_it_is(piece: bytes, seed: int) -> None:
    assert fate(piece, Faults(), Random(seed)) == Fate(piece, 0.0, ())


@given(PIECES, SEEDS)
def test_flip_changes_one_bit(piece: bytes, seed: int) -> None:
    suffered = fate(piece, Faults(flip_probability=1.0), Random(seed))
    assert suffered.struck == ("flipped",)
    assert differing_bits(suffered.piece, piece) == 1


@given(PIECES, SEEDS)
def test_of_seals_only_those_at_the_end_of_a_whole_frame_are_flipped(said: bytes, seed: int) -> None:
    flipping, message = Faults(flip_probability=1.0, only_seals=True), sealed(said)
    frame = batch(bytes([FRAME]) + message)
    suffered = fate(frame, flipping, Random(seed))
    assert suffered.struck == ("flipped",)
    assert suffered.piece[:-SEAL_BYTES] == frame[:-SEAL_BYTES]
    assert differing_bits(suffered.piece, frame) == 1
    for other in (frame[:-1], message, batch(bytes([FRAME])), batch(b"\x04" + message)):
        assert fate(other, flipping, Random(seed)) == Fate(other, 0.0, ())


@given(PIECES, SEEDS)
def test_truncation_takes_the_end_away(piece: bytes, seed: int) -> None:
    suffered = fate(piece, Faults(truncate_probability=1.0), Random(seed))
    assert suffered.struck == ("truncated",)
    assert piece.startswith(suffered.piece)
    assert len(suffered.piece) < len(piece)


@given(PIECES, SEEDS)
def test_jitter_is_added_to_the_delay(piece: bytes, seed: int) -> None:
    suffered = fate(piece, Faults(delay_s=0.05, jitter_s=0.02), Random(seed))
    assert 0.05 <= suffered.delay_s <= 0.07


@given(st.lists(PIECES, max_size=20), SEEDS)
def test_one_fault_more_moves_no_draw_of_the_others(pieces: list[bytes], seed: int) -> None:
    some, more = Random(seed), Random(seed)
    few = [fate(piece, Faults(flip_probability=0.5), some) for piece in pieces]
    many = [fate(piece, Faults(flip_probability=0.5, delay_s=1.0, jitter_s=1.0), more) for piece in pieces]
    assert [(each.piece, each.struck) for each in few] == [(each.piece, each.struck) for each in many]


def batch(said: bytes) -> bytes:
    return len(said).to_bytes(2, "little") + said


@given(st.lists(PIECES, max_size=3), PIECES)
def test_what_is_forged_follows_in_the_last_batch_if_that_is_a_whole_frame(
    before: list[bytes], said: bytes
) -> None:
    earlier, frame = b"".join(map(batch, before)), bytes([FRAME]) + said
    forging = Faults(forged=b"and that")
    assert fate(earlier + batch(frame), forging, Random(1)).piece == earlier + batch(frame + b"and that")
    for other in (batch(frame)[:-1], batch(frame) + b"\x00\x00", batch(b"\x04")):
        assert fate(earlier + other, forging, Random(1)).piece == earlier + other


@pytest.mark.parametrize("name", ["flip_probability", "truncate_probability", "reset_probability"])
def test_probability_above_one_is_refused(name: str) -> None:
    too_likely: dict[str, Any] = {name: 1.5}
    with pytest.raises(ValueError, match=f"{name} must be within 0 and 1, got 1.5"):
        Faults(**too_likely)


async def test_without_faults_everything_comes_through() -> None:
    async with through_proxy() as (between, streams):
        assert await answer(streams, LONG) == LONG
        assert between.counts == {"connected": 1}


async def test_same_seed_flips_the_same_bit() -> None:
    answers = []
    for _ in range(2):
        async with through_proxy(seed=7) as (between, streams):
            between.faults[Way.UP] = Faults(flip_probability=1.0)
            answers.append(await answer(streams, b"a small piece"))
            assert between.counts["flipped"] == 1
    assert answers[0] == answers[1]
    assert differing_bits(answers[0], b"a small piece") == 1


async def test_order_is_kept_under_jitter() -> None:
    async with through_proxy() as (between, streams):
        between.faults[Way.UP] = between.faults[Way.DOWN] = Faults(jitter_s=0.005)
        assert await answer(streams, LONG) == LONG


async def test_both_ways_are_delayed() -> None:
    async with through_proxy() as (between, streams):
        between.faults[Way.UP] = between.faults[Way.DOWN] = Faults(delay_s=0.05)
        began_s = asyncio.get_running_loop().time()
        assert await answer(streams, b"late") == b"late"
        assert asyncio.get_running_loop().time() - began_s >= 0.1


async def test_reset_by_a_piece_ends_the_connection() -> None:
    async with through_proxy() as (between, streams):
        between.faults[Way.UP] = Faults(reset_probability=1.0)
        with pytest.raises(ConnectionResetError):
            await answer(streams, b"never")
        assert between.counts["reset"] == 1


async def test_server_that_is_not_there_ends_the_connection() -> None:
    async with proxy(1) as (_, port):  # nobody listens at port 1
        reader, writer = await asyncio.open_connection("127.0.0.1", port)
        assert await reader.read() == b""
        writer.close()


def test_a_link_that_loses_frames_keeps_handshakes_and_signs_of_life() -> None:
    def batch(kind: int, *rest: int) -> bytes:
        return bytes((1 + len(rest), 0, kind, *rest))

    init, alive = batch(0x01, 7, 8), batch(0x04)
    lossy = fate(init + batch(FRAME, 9) + alive + batch(0xA0 | FRAME), Faults(frames_lost=True), Random(1))
    assert lossy.piece == init + alive
