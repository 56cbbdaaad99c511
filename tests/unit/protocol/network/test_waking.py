"""An alarm wakes the task that waits for it in a loop of several tasks."""

import asyncio
import time
from threading import Thread

from protocol.network.inbox import Alarm
from tests.support.deadline import DEADLINE_S


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
