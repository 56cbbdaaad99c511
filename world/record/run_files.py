"""What stands in a run's folder beside its entries: the header of the timeline, and the verdict."""

import platform
from importlib import metadata
from pathlib import Path

import msgspec

from protocol.faults.plan import Plan
from protocol.files.opening import MADE_BYTES_MAX, read_bytes
from world.judge.verdict import VERDICT_FILE, Verdict
from world.record.recorder import Header, RecordingFailedError
from world.scenario.scenario import Scenario

VERSIONS_OF = {"zenoh": "eclipse-zenoh", "clew": "clew"}  # by the names of their distributions


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
        faults=msgspec.to_builtins(plan) if plan.rules else None,
    )


def save_verdict(verdict: Verdict, folder: Path) -> None:
    """Write `verdict.json` into the run's folder.

    Raises:
        RecordingFailedError: it cannot be written.
    """
    path = folder / VERDICT_FILE
    try:
        path.write_bytes(msgspec.json.format(msgspec.json.encode(verdict)) + b"\n")
    except OSError as error:
        raise RecordingFailedError(f"cannot write {path}: {error.strerror}") from error


def _version(distribution: str) -> str:
    try:
        return metadata.version(distribution)
    except metadata.PackageNotFoundError:  # run from a tree that was never set up
        return "not installed"


def read_verdict(folder: Path) -> Verdict:
    """The verdict in a run's folder.

    Raises:
        OSError: there is none.
        msgspec.MsgspecError: it is no verdict.
    """
    return msgspec.json.decode(read_bytes(folder / VERDICT_FILE, MADE_BYTES_MAX), type=Verdict)
