"""Plays episodes on several processes and yields what came of them, as it comes.

Rule 1: an episode whose process dies has an outcome, too. All episodes that were running at that moment are
        played again, one at a time, to find the one that kills its process.
Rule 2: workers do not see Ctrl-C, nor a SIGTERM to all our processes; the campaign ends them. An
        episode that was stopped so has no outcome. They end by themselves if the campaign is killed.
"""

import multiprocessing
import os
import signal
import threading
from collections import deque
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import FIRST_COMPLETED, Future, ProcessPoolExecutor, wait
from concurrent.futures.process import BrokenProcessPool
from contextlib import contextmanager

from clew.campaign.episode import CRASHED, Episode, Outcome, failed, play
from protocol.process.asked import EXIT_CODES


def outcomes_of(episodes: Sequence[Episode], jobs: int) -> Iterator[Outcome]:
    """The outcomes in the order in which they come; one job plays in this process."""
    if jobs == 1:
        yield from map(play, episodes)
        return
    # Affects the workers only: they load numpy after this, the parent has loaded it already.
    os.environ["OPENBLAS_NUM_THREADS"] = "1"
    waiting, running = deque(episodes), list[Episode]()
    while waiting or running:
        try:
            yield from _pooled(waiting, running, jobs)
        except BrokenProcessPool:
            suspects = running.copy()
            running.clear()
            for each in suspects:
                yield _alone(each)


def lost(episode: Episode) -> Outcome:
    """The outcome of an episode whose process has died."""
    return failed(episode, CRASHED, "its process died", 0.0)


def _pooled(waiting: deque[Episode], running: list[Episode], jobs: int) -> Iterator[Outcome]:
    """Keep all workers busy; `running` holds the episodes that they play."""
    with _pool(jobs) as pool:

        def submit(episode: Episode) -> Future[Outcome]:
            running.append(episode)
            with _requests_kept_from_children():
                return pool.submit(play, episode)

        try:
            for episode, future in finished(waiting, submit, lambda: jobs):
                result = future.result()
                running.remove(episode)
                yield result
        finally:
            if running:  # interrupted or broken: the results are not needed
                for worker in multiprocessing.active_children():
                    worker.kill()


def finished(
    waiting: deque[Episode], submit: Callable[[Episode], Future[Outcome]], at_once: Callable[[], int]
) -> Iterator[tuple[Episode, Future[Outcome]]]:
    """Submit what waits, so many at once, and yield each future that is done; more may come to wait."""
    futures: dict[Future[Outcome], Episode] = {}
    while waiting or futures:
        most = at_once()
        while waiting and len(futures) < most:
            episode = waiting.popleft()
            futures[submit(episode)] = episode
        done, _ = wait(futures, return_when=FIRST_COMPLETED)
        for future in done:
            yield futures.pop(future), future


def _alone(episode: Episode) -> Outcome:
    with _pool(1) as pool:
        try:
            with _requests_kept_from_children():
                coming = pool.submit(play, episode)
            return coming.result()
        except BrokenProcessPool:
            return lost(episode)


def _pool(jobs: int) -> ProcessPoolExecutor:
    context = multiprocessing.get_context("spawn")
    return ProcessPoolExecutor(jobs, mp_context=context, initializer=_begin)


@contextmanager
def _requests_kept_from_children() -> Iterator[None]:
    """Child processes started in the body never get requests to end; we get them afterwards."""
    before = signal.pthread_sigmask(signal.SIG_BLOCK, EXIT_CODES.keys())
    try:
        yield
    finally:
        signal.pthread_sigmask(signal.SIG_SETMASK, before)


def _begin() -> None:
    threading.Thread(target=_end_with_parent, daemon=True).start()


def _end_with_parent() -> None:
    parent = multiprocessing.parent_process()
    assert parent is not None, "only workers call this"
    parent.join()
    os._exit(1)  # the main thread waits for episodes that will never be sent
