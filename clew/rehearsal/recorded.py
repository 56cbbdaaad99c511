"""Rehearses one run into a folder like a live run's: `events.jsonl`, then `verdict.json`. A shell.

Rule 1: scenario and seed determine the timeline to the byte. Wall-clock times stand only in the verdict
        (`started_at`, `wall_s`, `cpu_s`).
Rule 2: SIGINT, SIGTERM and SIGHUP end the rehearsed run as they end a live one: with a verdict.
"""

import time
from collections import Counter
from collections.abc import Callable, Iterator
from datetime import UTC, datetime
from functools import partial
from pathlib import Path
from typing import Self

from agents.process.journal import open_journal
from clew.rehearsal.endless_law import asked_to_end_in_laws
from clew.rehearsal.rehearsal import Asked, Rehearsal, nobody_asks
from protocol.errors import UsageError
from protocol.faults.plan import NO_FAULTS, Plan
from protocol.keys import WORLD
from protocol.network.session import INPUTS
from protocol.run_settings import Settings
from world.closing import Circumstances, verdict_of
from world.judge.verdict import Verdict
from world.record.progress import progress
from world.record.recorder import EVENTS_FILE, Header, Recorder, open_events
from world.record.run_files import header_of, prepare_folder, save_verdict
from world.scenario.scenario import Scenario

EPOCH = "1970-01-01T00:00:00+00:00"  # the start of each rehearsal by its own clock; `hlc` counts from there
KEPT_BYTES = 16_384  # of each journal in memory, where nobody looks before the end
FINGERPRINT_LENGTH = 12  # 48 bits: enough to distinguish scenarios in the name of a run


def rehearse(
    scenario: Scenario, seed: int, folder: Path, say: Callable[[str], None], plan: Plan = NO_FAULTS
) -> Verdict:
    """Rehearse a run into an existing folder; `say` gets the lines of progress.

    Raises:
        UsageError: the folder already holds a run, or the fault plan does not fit the fleet.
        RecordingFailedError: the timeline or the verdict cannot be written.
    """
    with (
        asked_to_end_in_laws() as asked,
        Recorded(scenario, seed, folder, plan, say, keeps_bytes=KEPT_BYTES) as recorded,
    ):
        for _ in recorded.ticks(lambda: asked[-1] if asked else None):
            pass
        return recorded.judge()


class Recorded:
    """A rehearsal that is written into an existing folder while it goes on.

    Raises:
        UsageError, RecordingFailedError: as `rehearse`.
    """

    def __init__(
        self,
        scenario: Scenario,
        seed: int,
        folder: Path,
        plan: Plan,
        say: Callable[[str], None],
        *,
        keeps_bytes: int = 0,
    ) -> None:
        self._started_at = datetime.now(UTC).isoformat(timespec="seconds")
        self._started_wall_s, self._started_cpu_s = time.monotonic(), time.process_time()
        self._seed, self._folder, self._say = seed, folder, say
        self._file = open_events(folder)
        self._lives: Counter[str] = Counter()
        try:
            prepare_folder(folder, scenario, plan, Settings(seed=seed))
            journals = partial(open_journal, folder / INPUTS, keeps_bytes=keeps_bytes)
            self._recorder = Recorder(self._file, _header(scenario, plan, seed), syncs=False)
            self.rehearsal = Rehearsal(scenario, seed, plan, journals=journals)
        except BaseException as error:
            self._file.close()
            if isinstance(error, UsageError):  # nothing has happened yet
                (folder / EVENTS_FILE).unlink()
            raise

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    def ticks(self, asked: Asked = nobody_asks) -> Iterator[float]:
        """Run tick by tick, as `Rehearsal.ticks`; what has happened is written before each time."""
        try:
            for now_s in self.rehearsal.ticks(asked):
                self._record()
                yield now_s
        finally:  # if a core fails, the last entries say why
            self._record()

    def judge(self) -> Verdict:
        """Write the verdict on the rehearsal, which has ended."""
        verdict = verdict_on(
            self.rehearsal,
            self._seed,
            started_at=self._started_at,
            wall_s=time.monotonic() - self._started_wall_s,
            cpu_s=time.process_time() - self._started_cpu_s,
        )
        save_verdict(verdict, self._folder)
        return verdict

    def close(self) -> None:
        """Close all files."""
        self.rehearsal.close()
        self._file.close()

    def _record(self) -> None:
        """Write the new entries. A source that counts from 1 again was restarted."""
        for source, entry in self.rehearsal.entries[self._recorder.recorded_count :]:
            self._lives[source] += entry.n == 1
            self._recorder.take(source, [entry], str(self._lives[source]))
            if (sentence := progress(source, entry)) is not None:
                self._say(sentence)


def verdict_on(
    rehearsal: Rehearsal, seed: int, *, started_at: str, wall_s: float, cpu_s: float = 0.0
) -> Verdict:
    """The verdict on a rehearsal that has ended."""
    return verdict_of(
        rehearsal.world,
        Circumstances(
            seed=seed,
            speed=None,
            started_at=started_at,
            plan=rehearsal.plan,
            traffic=rehearsal.account,
            recorded=len(rehearsal.entries),
            missing={},
            wall_s=wall_s,
            cpu_s=cpu_s,
        ),
    )


def _header(scenario: Scenario, plan: Plan, seed: int) -> Header:
    run = f"rehearsal-{scenario.fingerprint()[:FINGERPRINT_LENGTH]}-{seed}"
    return header_of(scenario, plan, run=run, seed=seed, speed=None, started_at=EPOCH, hlc=f"0/{WORLD}")
