"""The files in a run's folder besides its entries: the request, the header, and the verdict."""

import platform
from collections.abc import Mapping
from importlib import metadata
from pathlib import Path
from typing import Any

import msgspec

from protocol.errors import UsageError
from protocol.faults.plan import NO_FAULTS, Plan
from protocol.faults.plan_text import FAULTS_FILE
from protocol.files.opening import MADE_BYTES_MAX, read_bytes
from protocol.files.reading import read, understand
from protocol.files.toml_text import toml_text
from protocol.files.writing import write_whole
from protocol.law_files import copies
from protocol.run_settings import SCENARIO_FILE, Settings, read_plan, texts
from world.judge.together import TogetherVerdict
from world.judge.verdict import VERDICT_FILE, Verdict
from world.record.recorder import Header, must_write
from world.scenario.fleets import SharedGround
from world.scenario.scenario import Scenario

BEGUN_FILE = "begun"
"""In the private folder of a live run: it has had a timeline. Only the timeline can say how it goes on."""
VERSIONS_OF = {"zenoh": "eclipse-zenoh", "clew": "clew"}  # distribution names


def header_of(
    scenario: Scenario, plan: Plan, *, run: str, seed: int, speed: float | None, started_at: str, hlc: str
) -> Header:
    """The first line of a run's timeline."""
    return Header(
        hlc=hlc,
        run=run,
        seed=seed,
        speed=speed,
        started_at=started_at,
        scenario=msgspec.to_builtins(scenario),
        scenario_hash=scenario.fingerprint(),
        versions={
            "python": platform.python_version(),
            **{name: _version(distribution) for name, distribution in VERSIONS_OF.items()},
        },
        faults=as_header(plan),
    )


def prepare_folder(folder: Path, scenario: Scenario, plan: Plan, settings: Settings) -> None:
    """Write the resolved request into the run's folder, before anything starts.

    Raises:
        UsageError: it cannot be written.
    """
    _write(folder, scenario, texts(settings, plan))


def prepare_together(folder: Path, shared: SharedGround, settings: Settings) -> None:
    """Write what was asked for of several fleets into the run's folder; each fleet's own folder has the rest.

    Raises:
        UsageError: it cannot be written.
    """
    _write(folder, shared, texts(settings, NO_FAULTS))


def scenario_files(scenario: Scenario | SharedGround, name: str = SCENARIO_FILE) -> dict[str, bytes]:
    """A file that loads as this scenario, and the file of its law, which must lie beside it.

    Raises:
        UsageError: the file of the law is not here any more.
    """
    return {name: toml_text(msgspec.to_builtins(scenario)).encode(), **copies(scenario.law.law)}


def _write(folder: Path, scenario: Scenario | SharedGround, more: Mapping[str, str]) -> None:
    files = {**scenario_files(scenario), **{name: text.encode() for name, text in more.items()}}
    try:
        for name, text in files.items():
            write_whole(folder / name, text)
    except OSError as error:
        raise UsageError(f"cannot write into {folder}: {error.strerror}") from error


def read_scenario(folder: Path) -> Scenario:
    """Read the scenario of the run in this folder, whose law need not be here.

    Raises:
        UsageError: the file is missing or invalid.
    """
    path = folder / SCENARIO_FILE
    return understand(read(path, str(path)), Scenario, str(path))


def check_unchanged(folder: Path, header: Header) -> None:
    """Refuse a folder whose scenario or fault plan has changed since the run began.

    Raises:
        UsageError: one of them has changed.
    """
    began_with = () if header.faults is None else msgspec.convert(header.faults, Plan).rules
    if read_scenario(folder).fingerprint() != header.scenario_hash:
        raise UsageError(f"{folder / SCENARIO_FILE}: was changed after the run had begun")
    if read_plan(folder).rules != began_with:
        raise UsageError(f"{folder / FAULTS_FILE}: was changed after the run had begun")


def as_header(plan: Plan) -> dict[str, Any] | None:
    """The fault plan as a header contains it."""
    return msgspec.to_builtins(plan) if plan.rules else None


def mark_begun(private: Path) -> None:
    """Note in the private folder that the run has a timeline.

    Raises:
        RecordingFailedError: it cannot be written.
    """
    path = private / BEGUN_FILE
    with must_write(path):
        path.touch()


def save_verdict(verdict: Verdict | TogetherVerdict, folder: Path) -> None:
    """Write `verdict.json` into the run's folder.

    Raises:
        RecordingFailedError: it cannot be written.
    """
    path = folder / VERDICT_FILE
    with must_write(path):
        write_whole(path, msgspec.json.format(msgspec.json.encode(verdict)) + b"\n")


def _version(distribution: str) -> str:
    try:
        return metadata.version(distribution)
    except metadata.PackageNotFoundError:  # run from a source tree without installation
        return "not installed"


def read_verdict(folder: Path) -> Verdict:
    """Read the verdict in a run's folder.

    Raises:
        OSError: there is no verdict.
        msgspec.MsgspecError: the file is not a valid verdict.
    """
    return msgspec.json.decode(read_bytes(folder / VERDICT_FILE, MADE_BYTES_MAX), type=Verdict)


def read_together(folder: Path) -> TogetherVerdict:
    """Read the verdict on all fleets in the folder of a run with several.

    Raises:
        OSError, msgspec.MsgspecError: as `read_verdict`.
    """
    return msgspec.json.decode(read_bytes(folder / VERDICT_FILE, MADE_BYTES_MAX), type=TogetherVerdict)
