"""Rehearses one run into a folder like a live run's: `events.jsonl`, then `verdict.json`. A shell.

Rule 1: scenario and seed determine the timeline to the byte. Wall-clock times stand only in the verdict
        (`started_at`, `wall_s`, `cpu_s`).
Rule 2: SIGINT, SIGTERM and SIGHUP end the rehearsed run as they end a live one: with a verdict.
"""

import time
from collections import Counter
from collections.abc import Callable
from datetime import UTC, datetime
from pathlib import Path

from clew.rehearsal.rehearsal import Rehearsal
from protocol.asked import asked_to_end
from protocol.faults.plan import NO_FAULTS, Plan
from protocol.keys import WORLD
from protocol.network.session import INPUTS
from protocol.run_settings import Settings
from world.closing import Circumstances, verdict_of
from world.judge.verdict import Verdict
from world.record.progress import progress
from world.record.recorder import Header, Recorder, open_events
from world.record.run_files import header_of, prepare_folder, save_verdict
from world.scenario.scenario import Scenario

EPOCH = "1970-01-01T00:00:00+00:00"  # the start of each rehearsal by its own clock; `hlc` counts from there
FINGERPRINT_LENGTH = 12  # 48 bits: enough to distinguish scenarios in the name of a run


def rehearse(
    scenario: Scenario, seed: int, folder: Path, say: Callable[[str], None], plan: Plan = NO_FAULTS
) -> Verdict:
    """Rehearse a run into an existing folder; `say` gets the lines of progress.

    Raises:
        UsageError: the folder already holds a run, or the fault plan does not fit the fleet.
        RecordingFailedError: the timeline or the verdict cannot be written.
    """
    started_at, started_wall_s = datetime.now(UTC).isoformat(timespec="seconds"), time.monotonic()
    rehearsal = Rehearsal(scenario, seed, plan, inputs=folder / INPUTS)
    with open_events(folder) as file, asked_to_end() as asked:
        prepare_folder(folder, scenario, plan, Settings(seed=seed))
        recorder = Recorder(file, _header(scenario, plan, seed))
        lives: Counter[str] = Counter()
        try:
            for _ in rehearsal.ticks(lambda: asked[-1] if asked else None):
                _record(rehearsal, recorder, lives, say)
        finally:  # if a core fails, the last entries say why
            _record(rehearsal, recorder, lives, say)
            rehearsal.close()
    verdict = verdict_on(rehearsal, seed, started_at=started_at, wall_s=time.monotonic() - started_wall_s)
    save_verdict(verdict, folder)
    return verdict


def verdict_on(rehearsal: Rehearsal, seed: int, *, started_at: str, wall_s: float) -> Verdict:
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
            cpu_s=time.process_time(),
        ),
    )


def _record(
    rehearsal: Rehearsal, recorder: Recorder, lives: Counter[str], say: Callable[[str], None]
) -> None:
    """Write the new entries. A source that counts from 1 again was restarted."""
    for source, entry in rehearsal.entries[recorder.recorded_count :]:
        lives[source] += entry.n == 1
        recorder.take(source, [entry], str(lives[source]))
        if (sentence := progress(source, entry)) is not None:
            say(sentence)


def _header(scenario: Scenario, plan: Plan, seed: int) -> Header:
    run = f"rehearsal-{scenario.fingerprint()[:FINGERPRINT_LENGTH]}-{seed}"
    return header_of(scenario, plan, run=run, seed=seed, speed=None, started_at=EPOCH, hlc=f"0/{WORLD}")
