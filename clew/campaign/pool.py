"""Plays episodes on several processes, and gives their outcomes as they come.

Rule 1: an episode whose process dies is an outcome as well. Those that were on when it died are played
        again, each alone, so that the right one is blamed.
Rule 2: a worker never sees a Ctrl-C: the campaign ends it. It ends by itself where the campaign is killed.
"""

import multiprocessing
import os
import signal
import threading
from collections import deque
from collections.abc import Iterator, Sequence
from concurrent.futures import FIRST_COMPLETED, Future, ProcessPoolExecutor, wait
from concurrent.futures.process import BrokenProcessPool
from contextlib import contextmanager

from clew.campaign.episode import CRASHED, Episode, Outcome, failed, play


def outcomes_of(episodes: Sequence[Episode], jobs: int) -> Iterator[Outcome]:
    """The outcomes, in the order in which they come; with one job, in this process."""
    if jobs == 1:
        yield from map(play, episodes)
        return
    # The parent's numpy is there already; workers start afresh, and read this before theirs loads.
    os.environ["OPENBLAS_NUM_THREADS"] = "1"
    waiting, running = deque(episodes), list[Episode]()
    while waiting or running:
        try:
            yield from _pooled(waiting, running, jobs)
        except BrokenProcessPool:
            suspects = running.copy()
            running.clear()
            yield from map(_alone, suspects)


def _pooled(waiting: deque[Episode], running: list[Episode], jobs: int) -> Iterator[Outcome]:
    """Keep all workers busy; what is on them stands in `running`."""
    with _pool(jobs) as pool:
        futures: dict[Future[Outcome], Episode] = {}
        try:
            while waiting or futures:
                while waiting and len(futures) < jobs:
                    running.append(waiting.popleft())
                    with _interrupt_kept_from_children():
                        futures[pool.submit(play, running[-1])] = running[-1]
                done, _ = wait(futures, return_when=FIRST_COMPLETED)
                for future in done:
                    outcome = future.result()
                    running.remove(futures.pop(future))
                    yield outcome
        finally:
            if futures:  # interrupted or broken: nobody waits for these
                for worker in multiprocessing.active_children():
                    worker.terminate()


def _alone(episode: Episode) -> Outcome:
    with _pool(1) as pool:
        try:
            with _interrupt_kept_from_children():
                coming = pool.submit(play, episode)
            return coming.result()
        except BrokenProcessPool:
            return failed(episode, CRASHED, "its process died", 0.0)


def _pool(jobs: int) -> ProcessPoolExecutor:
    context = multiprocessing.get_context("spawn")
    return ProcessPoolExecutor(jobs, mp_context=context, initializer=_begin)


@contextmanager
def _interrupt_kept_from_children() -> Iterator[None]:
    """Who is started meanwhile never hears the user's interrupt, not even while it imports; we do, later."""
    before = signal.pthread_sigmask(signal.SIG_BLOCK, {signal.SIGINT})
    try:
        yield
    finally:
        signal.pthread_sigmask(signal.SIG_SETMASK, before)


def _begin() -> None:
    threading.Thread(target=_end_with_parent, daemon=True).start()


def _end_with_parent() -> None:
    parent = multiprocessing.parent_process()
    assert parent is not None, "only workers begin"
    parent.join()
    os._exit(1)  # the main thread waits for episodes that nobody will ever send
