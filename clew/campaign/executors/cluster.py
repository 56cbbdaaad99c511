"""Plays episodes on the workers of a Dask cluster. A shell.

Rule 1: the campaign stays here: workers play, and only this process writes outcomes. So the result is that of
        a campaign on local processes, but for the order of the lines and the times in them.
Rule 2: Dask plays an episode again whose worker has died, and gives it up when that was so a few times. Then
        we send it again: workers may die for reasons of their own. After `TRIES` it is the episode's fault.
Rule 3: only so many episodes are sent ahead as keep all workers busy: a campaign may have millions.
"""

from collections import Counter, deque
from collections.abc import Iterator, Sequence
from functools import partial
from typing import TYPE_CHECKING

from clew.campaign.episode import Episode, Outcome
from clew.campaign.executors.player import play_apart
from clew.campaign.executors.pool import finished, lost
from protocol.errors import ClewError, UsageError

if TYPE_CHECKING:  # the extra `cluster`, which a campaign on this machine does not need
    from distributed import Client

TRIES = 3  # of Dask's own: with its default of 3 retries, some ten workers have died by then
AHEAD = 2  # episodes sent for each thread of a worker: one is played, and one waits
PATIENCE_S = 10.0  # for the scheduler, and for the first worker


class ClusterLostError(ClewError):
    """The scheduler cannot be reached any more; what is done is written."""


def cluster_outcomes(
    episodes: Sequence[Episode], _jobs: int, *, scheduler: str, source_hash: str
) -> Iterator[Outcome]:
    """The outcomes in the order in which they come.

    Args:
        episodes: what to play.
        scheduler: the address of a Dask scheduler, such as tcp://127.0.0.1:8786.
        source_hash: of our own source, which must be that of all workers.

    Raises:
        UsageError: there is no such scheduler, it has no worker, or a worker has another source or no scene.
        ClusterLostError: the scheduler is gone.
    """
    from distributed import Client, KilledWorker  # noqa: PLC0415 - see above

    try:
        client = Client(scheduler, timeout=PATIENCE_S, set_as_default=False)
    except (OSError, ValueError) as error:  # a time-out, too, and an address of no known kind
        raise UsageError(f"--scheduler {scheduler}: no Dask scheduler answers there") from error
    with client:
        _wait_for_a_worker(client, scheduler)
        executor, tries = client.get_executor(pure=False), Counter[str]()
        submit = partial(executor.submit, play_apart, source_hash=source_hash)
        waiting = deque(episodes)
        for episode, future in finished(waiting, submit, lambda: AHEAD * _threads(client)):
            if future.cancelled():
                raise ClusterLostError(f"the scheduler {scheduler} is gone; the same command goes on later")
            if not isinstance(future.exception(), KilledWorker):
                yield future.result()
                continue
            tries[episode.key] += 1
            if tries[episode.key] < TRIES:
                waiting.append(episode)
            else:
                yield lost(episode)


def _wait_for_a_worker(client: "Client", scheduler: str) -> None:
    try:
        client.wait_for_workers(1, timeout=PATIENCE_S)
    except TimeoutError as error:
        raise UsageError(f"--scheduler {scheduler}: it has no worker") from error


def _threads(client: "Client") -> int:
    """How many episodes the workers can play at once; one, while all are started again."""
    return max(int(sum(client.nthreads().values())), 1)
