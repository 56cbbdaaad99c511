"""A process with one task: its bell wakes it, and a request to end is raised where it waits."""

import os
import signal
import time
from threading import Timer

import pytest

from protocol.exit_codes import ExitCode
from protocol.process.alone import Bell, run_alone
from protocol.process.ending import FAIL
from tests.support.deadline import DEADLINE_S


def test_a_bell_that_another_thread_rings_ends_the_wait_and_a_ring_before_it_ends_the_next_wait_only() -> (
    None
):
    async def waits(bell: Bell) -> list[float]:
        took_s = list[float]()
        bell.ring()
        bell.ring()
        for timeout_s, rings in ((None, False), (0.05, False), (None, True)):
            since_s = time.monotonic()
            timer = Timer(0.01, bell.ring)
            if rings:
                timer.start()
            await bell.wait(timeout_s)
            took_s.append(time.monotonic() - since_s)
            if rings:
                timer.join()
        return took_s

    took_s = run_alone(waits, None)
    assert isinstance(took_s, list)
    rung_before_s, silent_s, rung_s = took_s
    assert rung_before_s < DEADLINE_S
    assert silent_s >= 0.05
    assert rung_s >= 0.01


@pytest.mark.parametrize(
    ("number", "exit_code"), [(signal.SIGTERM, ExitCode.TERMINATED), (FAIL, ExitCode.FAILED)]
)
def test_a_signal_ends_a_task_where_it_waits_and_its_contexts_are_left(
    number: signal.Signals, exit_code: ExitCode
) -> None:
    left: list[int] = []

    async def waits(bell: Bell) -> int:
        timer = Timer(0.01, os.kill, (os.getpid(), number))
        timer.start()  # here signals are heard: before that, one would end us
        try:
            while True:
                await bell.wait(DEADLINE_S)
        finally:
            timer.join()
            left.append(number)

    since_s, before = time.monotonic(), signal.getsignal(number)
    assert run_alone(waits, None) == exit_code
    assert left == [number]
    assert signal.getsignal(number) is before
    assert time.monotonic() - since_s < DEADLINE_S


def test_a_signal_that_comes_between_two_waits_ends_the_task_at_the_next() -> None:
    did: list[str] = []

    async def works(bell: Bell) -> int:
        os.kill(os.getpid(), signal.SIGTERM)
        did.append("the whole step")
        await bell.wait(None)
        did.append("another step")
        return 0

    assert run_alone(works, None) == ExitCode.TERMINATED
    assert did == ["the whole step"]


def test_a_signal_that_asks_for_nothing_ends_nothing() -> None:
    async def works(bell: Bell) -> int:
        os.kill(os.getpid(), signal.SIGALRM)
        await bell.wait(DEADLINE_S)
        return 7

    before = signal.signal(signal.SIGALRM, lambda _number, _frame: None)
    try:
        assert run_alone(works, None) == 7
    finally:
        signal.signal(signal.SIGALRM, before)


def test_the_end_of_the_lifeline_ends_a_task_and_what_it_says_does_not() -> None:
    reading_end, writing_end = os.pipe()
    waited = 0

    async def waits(bell: Bell) -> int:
        nonlocal waited
        os.write(writing_end, b"not the end")
        await bell.wait(DEADLINE_S)
        waited += 1
        os.close(writing_end)
        await bell.wait(DEADLINE_S)
        return 0

    assert run_alone(waits, reading_end) == ExitCode.TERMINATED
    assert waited == 1
    os.close(reading_end)


def test_a_result_is_returned() -> None:
    async def works(_bell: Bell) -> str:
        return "done"

    assert run_alone(works, None) == "done"
