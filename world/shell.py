"""The shell of the world: one fleet, or several that share one ground and one clock. It decides nothing.

Rule 1: the verdict is written however the run ends, as long as the timeline could be written.
Rule 2: the clocks of all fleets tick together, once those of all whose runs go on are due. So each scan shows
        the bodies of all fleets as they are at one instant.
Rule 3: a fleet whose run has ended stands where it is, and the others go on.
"""

import asyncio
import contextlib
import logging
import secrets
import time
from collections.abc import AsyncIterator, Sequence
from datetime import UTC, datetime

from protocol.exit_codes import ExitCode
from protocol.keys import WORLD
from protocol.network.transport import Arrival, Transport
from protocol.network.zenoh_transport import open_transport
from protocol.process.ending import asked_to_end
from world.bodies.arena import ODOMETRY_TICKS
from world.control import Serves, heard
from world.faults import RunFaults
from world.judge.hulls import AllHulls
from world.judge.verdict import Verdict
from world.life import Life, Request
from world.pace import GLANCE_S
from world.record.readback import Readback
from world.record.recorder import EVENTS_FILE, Header, Recorder, RecordingFailedError, Written, open_events
from world.record.resume import continue_events, read_past
from world.record.run_files import BEGUN_FILE, check_unchanged, header_of, mark_begun, save_verdict

log = logging.getLogger("world")


def run(requests: Sequence[Request], hulls: AllHulls | None = None) -> list[Verdict]:
    """Execute the runs of all fleets to their verdicts; `hulls` shows each the others.

    Raises:
        UsageError: no router admits us, or a run's folder is unusable.
        RecordingFailedError: a timeline or a verdict can no longer be written.
        SessionLostError: see `open_transport`; the timelines are complete until then.
    """
    verdicts = asyncio.run(_run(requests, hulls))
    for request, verdict in zip(requests, verdicts, strict=True):
        save_verdict(verdict, request.out)
    return verdicts


async def _run(requests: Sequence[Request], hulls: AllHulls | None) -> list[Verdict]:
    async with contextlib.AsyncExitStack() as stack:
        ending = stack.enter_context(asked_to_end(requests[0].lifeline))
        lives = [await stack.enter_async_context(_opened(request)) for request in requests]
        if hulls is not None:
            for life in lives:
                life.share_ground(hulls.others_of(life.fleet))
        await _live(lives, ending, hulls)
        return [life.verdict for life in lives if life.verdict is not None]


@contextlib.asynccontextmanager
async def _opened(request: Request) -> AsyncIterator[Life]:
    """The life of one fleet, with its session and its files."""
    faults, written = RunFaults(request.plan, request.seed, robots=request.scenario.fleet.robots), Written()
    past = read_past(request.out, faults.recall, written.recall) if request.resume else None
    begun = request.private / BEGUN_FILE
    if past is None and begun.exists():
        raise RecordingFailedError(f"{request.out / EVENTS_FILE} was removed: a run cannot go on without it")
    if past is not None:
        check_unchanged(request.out, past.header)
    keys = request.session.keys
    hear = [keys.drive("*"), keys.fence("*"), keys.log("*")]
    answer = [keys.scan("*"), keys.mission()]
    alive, watch = keys.alive(WORLD, secrets.token_hex(4)), [keys.tokens_of("*")]
    with contextlib.ExitStack() as files:
        if past is not None:  # first of all: nobody is to see a second world of a run
            file = files.enter_context(continue_events(request.out, past.whole_bytes))
        transport = files.enter_context(
            open_transport(request.session, hear=hear, answer=answer, alive=alive, watch=watch)
        )
        if past is None:  # last, so that a run that cannot start leaves no files
            file = files.enter_context(open_events(request.out))
        header = _header(request, transport) if past is None else past.header
        recorder = Recorder(file, header if past is None else None, written)
        mark_begun(request.private)
        with contextlib.closing(Readback(request.out, file)) as readback:
            life = Life(request, transport, recorder, readback, header.started_at, faults=faults, past=past)
            serves = Serves(life.add_fault, life.end_fault, life.halt, life.go)
            async with heard(request.private, request.out, serves):
                yield life


def _header(request: Request, transport: Transport) -> Header:
    return header_of(
        request.scenario,
        request.plan,
        run=request.session.run,
        seed=request.seed,
        speed=request.speed,
        started_at=datetime.now(UTC).isoformat(timespec="seconds"),
        hlc=transport.timestamp(),
    )


async def _live(lives: Sequence[Life], ending: asyncio.Future[ExitCode], hulls: AllHulls | None) -> None:
    """Run until the runs of all have been judged."""
    going = list(lives)
    for life in going:
        life.begin()
    while going:
        # A resumed world reads the whole timeline again, as fast as its other work allows.
        is_behind = any(life.is_behind for life in going)
        wait_s = 0.0 if is_behind else _wait_s(going, time.monotonic())
        for life in going:
            life.note_turn(time.monotonic(), asked_s=wait_s)
        arrivals = await _arrivals(going, wait_s)
        asked = ending.result() if ending.done() else None
        for life, arrived in zip(going, arrivals, strict=True):
            life.turn(arrived, asked)
        going = [life for life in going if life.verdict is None]
        for _ in range(ODOMETRY_TICKS):  # then arrivals are processed
            if not going or _wait_s(going, time.monotonic()) > 0.0:
                break
            for life in going:
                life.tick()
            _move(lives, hulls)
        for life in going:
            life.after_ticks()


def _wait_s(going: Sequence[Life], wall_s: float) -> float:
    """How long until all clocks are due (rule 2) [wall s]; no clock ticks before all robots have come."""
    if not all(life.has_started for life in going):
        return GLANCE_S
    waits_s = {life: life.wait_s(wall_s) for life in going}
    running = [life for life in going if not life.is_over]
    return max(waits_s[life] for life in running or going)


async def _arrivals(going: Sequence[Life], wait_s: float) -> list[Sequence[Arrival]]:
    """Wait until something arrives for one of them; what has arrived for each."""
    if len(going) == 1:
        return [await _arrived(going[0], wait_s)]
    waits = [asyncio.ensure_future(_arrived(life, wait_s)) for life in going]
    try:
        await asyncio.wait(waits, return_when=asyncio.FIRST_COMPLETED)
    finally:
        for each in waits:
            each.cancel()  # does nothing to those that are done
    await asyncio.wait(waits)
    return [
        await _arrived(life, 0.0) if each.cancelled() else each.result()
        for life, each in zip(going, waits, strict=True)
    ]


async def _arrived(life: Life, wait_s: float) -> Sequence[Arrival]:
    """Wait until something arrives for a fleet; while it is flooded, only let the loop do its other work."""
    if life.is_flooded:
        await asyncio.sleep(0)
        return ()
    return await life.arrivals(wait_s)


def _move(lives: Sequence[Life], hulls: AllHulls | None) -> None:
    """Show the bodies of all fleets where they are after a tick."""
    if hulls is not None:
        places_m = {life.fleet: life.places_m for life in lives}
        for contact in hulls.move(places_m, t_s=max(life.now_s for life in lives)):
            log.info("contact: %s", contact)
