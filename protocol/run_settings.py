"""The settings in a run's folder before anything starts: the user's request, resolved.

Rule 1: the command that starts a run reads the user's files once. All processes of the run, including a
        resumed world, read these copies. So an edit of the user's files during the run has no effect.
Rule 2: `scenario.toml` and `faults.toml` are valid input files for a new run.
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
SCENARIO_FILE = "scenario.toml"  # written and read by the world's code
SEED_MAX = 2**53 - 1  # JSON readers keep integers exact up to 2**53
SPEED_MAX = 1000.0  # a tick of 0.02 s then takes 20 us of wall time, which no world reaches


class Settings(Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """The settings of a run besides scenario and fault plan."""

    seed: Annotated[int, Meta(ge=0, le=SEED_MAX)]
    """Decides all random draws."""
    speed: Annotated[float, Meta(gt=0.0, le=SPEED_MAX)] | None = None
    """Simulated seconds per second; None: as fast as the robots answer."""
    held: bool = False
    """Whether in lock-step simulated time goes on only as far as it is asked to (`GoRequest`)."""


def texts(settings: Settings, plan: Plan) -> dict[str, str]:
    """The contents of the files to write into the run's folder, by file name."""
    plans = {FAULTS_FILE: plan_text(plan)} if plan.rules else {}
    return {SETTINGS_FILE: toml_text(msgspec.to_builtins(settings)), **plans}


def read_settings(run: Path) -> Settings:
    """Read the settings of the run in this folder.

    Raises:
        UsageError: the file is missing or invalid.
    """
    path = run / SETTINGS_FILE
    return understand(read(path, str(path)), Settings, str(path))


def read_plan(run: Path) -> Plan:
    """Read the fault plan of the run in this folder.

    Raises:
        UsageError: the file is invalid.
    """
    path = run / FAULTS_FILE
    return understand(read(path, str(path)), Plan, str(path)) if path.exists() else NO_FAULTS


def check_is_run(run: Path) -> None:
    """Refuse a folder without a prepared run.

    Raises:
        UsageError: there is no prepared run.
    """
    if not (run / SETTINGS_FILE).is_file():
        raise UsageError(f"{run}: no run has been prepared there: it has no {SETTINGS_FILE}")
