"""What wakes a task: an alarm in a loop of several tasks, a bell in a loop of one."""

import asyncio
import os
import signal
import subprocess
import sys
import time
from collections.abc import Coroutine
from threading import Thread, Timer
from typing import TypeVar

from protocol.exit_codes import ExitCode
from protocol.network.inbox import Alarm, Bell, OneTaskLoop, alarm
from protocol.process.ending import until_ended
from tests.support.deadline import DEADLINE_S

T = TypeVar("T")

ROBOTS = 501  # Linux lets 500 epolls watch others that watch one file (fs/eventpoll.c: path_limits)
BELLS = f"""
import os, resource
from protocol.network.inbox import Bell, OneTaskLoop
_, most = resource.getrlimit(resource.RLIMIT_NOFILE)
resource.setrlimit(resource.RLIMIT_NOFILE, (most, most))
lifeline, _ = os.pipe()
loops = [OneTaskLoop() for _ in range({ROBOTS})]
for loop in loops:
    loop.add_reader(lifeline, print)
bells = [Bell(loop) for loop in loops]
os._exit(0)
"""


def test_an_alarm_that_another_thread_rings_ends_the_wait_and_a_ring_before_it_does_not() -> None:
    async def waits() -> tuple[float, float]:
        alarm = Alarm(asyncio.get_running_loop())
        alarm.ring()
        await asyncio.sleep(0)
        since_s = time.monotonic()
        await alarm.wait(0.05)
        until_s = time.monotonic()
        rings = Thread(target=alarm.ring)
        asyncio.get_running_loop().call_later(0.01, rings.start)
        await alarm.wait(DEADLINE_S)
        rings.join()
        return until_s - since_s, time.monotonic() - until_s

    slept_s, woken_s = asyncio.run(waits())
    assert slept_s >= 0.05
    assert woken_s < DEADLINE_S


def test_a_wait_without_time_lets_other_tasks_run() -> None:
    async def waits() -> int:
        runs = 0

        async def other() -> None:
            nonlocal runs
            while True:
                runs += 1
                await asyncio.sleep(0)

        task = asyncio.ensure_future(other())
        await Alarm(asyncio.get_running_loop()).wait(0.0)
        task.cancel()
        return runs

    assert asyncio.run(waits()) > 0


def test_an_alarm_that_rings_after_the_loop_has_ended_rings_for_nobody() -> None:
    async def made() -> Alarm:
        return Alarm(asyncio.get_running_loop())

    asyncio.run(made()).ring()


def _in_one_task(work: Coroutine[None, None, T]) -> T:
    with asyncio.Runner(loop_factory=OneTaskLoop) as runner:
        return runner.run(work)


async def _bell() -> Bell:
    bell = alarm(asyncio.get_running_loop())
    assert isinstance(bell, Bell)
    return bell


def test_all_the_robots_of_a_large_host_may_wait_for_a_bell_and_watch_one_lifeline() -> None:
    made = subprocess.run(
        [sys.executable, "-c", BELLS], capture_output=True, text=True, timeout=DEADLINE_S, check=False
    )
    assert (made.returncode, made.stderr) == (0, "")


def test_a_bell_that_another_thread_rings_ends_the_wait_and_a_ring_before_it_ends_the_next_wait_only() -> (
    None
):
    async def waits() -> list[float]:
        bell, took_s = await _bell(), list[float]()
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

    rung_before_s, silent_s, rung_s = _in_one_task(waits())
    assert rung_before_s < DEADLINE_S
    assert silent_s >= 0.05
    assert rung_s >= 0.01


def test_while_a_task_waits_for_a_bell_its_loop_still_hears_signals_and_files() -> None:
    async def waits(timer: Timer) -> int:
        bell = await _bell()
        timer.start()  # here the loop handles signals: before that, one would end us
        while True:
            await bell.wait(DEADLINE_S)

    since_s = time.monotonic()
    reading_end, writing_end = os.pipe()
    raises = Timer(0.01, os.kill, (os.getpid(), signal.SIGTERM))
    assert _in_one_task(until_ended(waits(raises), reading_end)) == ExitCode.TERMINATED
    raises.join()
    closes = Timer(0.01, os.close, (writing_end,))
    assert _in_one_task(until_ended(waits(closes), reading_end)) == ExitCode.TERMINATED
    closes.join()
    os.close(reading_end)
    assert time.monotonic() - since_s < DEADLINE_S


def test_a_loop_with_other_tasks_has_an_alarm_so_that_they_run() -> None:
    async def made() -> object:
        return alarm(asyncio.get_running_loop())

    assert isinstance(asyncio.run(made()), Alarm)
