"""Rehearsed runs that many tests read. The first worker that needs a run makes it, once per session."""

import fcntl
import shutil
from dataclasses import dataclass
from pathlib import Path

from clew.rehearsal.recorded import rehearse
from protocol.faults.plan import NO_FAULTS
from protocol.faults.plan import load as load_plan
from tests.support.judges import differences
from world.judge.verdict import VERDICT_FILE
from world.scenario.scenario import load


@dataclass(frozen=True, slots=True)
class Runs:
    """The folder that all workers of a session share."""

    folder: Path

    def of(self, scenario: str, *, faults: str = "", seed: int = 1) -> Path:
        """The folder of such a run, for reading only."""
        name = f"{Path(scenario).name}-{Path(faults).name}-{seed}"
        run = self.folder / name
        with (self.folder / f"{name}.lock").open("w") as lock:
            fcntl.flock(lock, fcntl.LOCK_EX)
            if not (run / VERDICT_FILE).exists():
                run.mkdir()
                plan = load_plan(faults) if faults else NO_FAULTS
                verdict = rehearse(load(scenario), seed, run, lambda _: None, plan)
                assert not any(verdict.violations_by_invariant.values()), verdict.reason
                assert differences(run) == [], "the second judge agrees"
        return run

    def copy(self, to: Path, scenario: str, *, faults: str = "", seed: int = 1) -> Path:
        """A copy of such a run in a folder of the test."""
        return Path(shutil.copytree(self.of(scenario, faults=faults, seed=seed), to))
