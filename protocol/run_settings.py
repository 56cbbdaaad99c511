"""What a run's folder holds before anything starts: what the user asked for, resolved.

Rule 1: the user's own files are read once, by the command that starts the run. All processes of the run,
        a world that is started again included, read these copies. So an edit meanwhile changes nothing.
Rule 2: `scenario.toml` and `faults.toml` are files that a new run takes as they are.
"""

from pathlib import Path
from typing import Annotated

import msgspec
from msgspec import Meta, Struct

from protocol.errors import UsageError
from protocol.faults.plan import NO_FAULTS, Plan
from protocol.faults.plan_text import FAULTS_FILE, plan_text
from protocol.files.reading import read, understand
from protocol.files.toml_text import toml_text

SETTINGS_FILE = "run.toml"
SCENARIO_FILE = "scenario.toml"  # the world's, which alone knows what a scenario is
SEED_MAX = 2**53 - 1  # what JSON readers keep exact
SPEED_MAX = 1000.0  # a tick of 0.02 s is then 20 us of wall time, which no world keeps


class Settings(Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """How a run is run."""

    seed: Annotated[int, Meta(ge=0, le=SEED_MAX)]
    """Decides every random draw."""
    speed: Annotated[float, Meta(gt=0.0, le=SPEED_MAX)] | None = None
    """Simulated seconds per second; None: as fast as the robots answer."""


def texts(settings: Settings, plan: Plan) -> dict[str, str]:
    """What to write into the run's folder, by the names of the files."""
    plans = {FAULTS_FILE: plan_text(plan)} if plan.rules else {}
    return {SETTINGS_FILE: toml_text(msgspec.to_builtins(settings)), **plans}


def read_settings(run: Path) -> Settings:
    """How the run in this folder is run.

    Raises:
        UsageError: its file is not there, or is none.
    """
    path = run / SETTINGS_FILE
    return understand(read(path, str(path)), Settings, str(path))


def read_plan(run: Path) -> Plan:
    """The fault plan of the run in this folder.

    Raises:
        UsageError: its file is none.
    """
    path = run / FAULTS_FILE
    return understand(read(path, str(path)), Plan, str(path)) if path.exists() else NO_FAULTS


def check_is_run(run: Path) -> None:
    """Refuse a folder that nothing has been prepared in.

    Raises:
        UsageError: this is one.
    """
    if not (run / SETTINGS_FILE).is_file():
        raise UsageError(f"{run}: no run has been prepared there: it has no {SETTINGS_FILE}")
