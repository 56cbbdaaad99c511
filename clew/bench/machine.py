"""Where a benchmark runs, and with which versions. A shell: it reads the machine."""

import os
import platform
import subprocess
from datetime import UTC, datetime
from importlib import metadata
from pathlib import Path

from clew.bench.result import Machine
from protocol.root import ROOT

PACKAGES = ("eclipse-zenoh", "msgpack", "msgspec", "numpy", "scipy")
CPUINFO = Path("/proc/cpuinfo")


def machine() -> Machine:
    """The machine, and its load at this moment."""
    pages, page_bytes = os.sysconf("SC_PHYS_PAGES"), os.sysconf("SC_PAGE_SIZE")
    return Machine(
        cpu=cpu_model(CPUINFO.read_text(encoding="utf-8") if CPUINFO.exists() else ""),
        cores=len(os.sched_getaffinity(0)),
        memory_mb=pages * page_bytes // 1_000_000,
        kernel=platform.release(),
        load=round(os.getloadavg()[0], 2),
    )


def cpu_model(cpuinfo: str) -> str:
    """The processor's model as Linux tells it; ARM has no such line, so there it is the architecture."""
    for line in cpuinfo.splitlines():
        name, _, value = line.partition(":")
        if name.strip() == "model name":
            return value.strip()
    return platform.machine()


def versions(*more: str) -> dict[str, str]:
    """The versions of Python, Clew and the packages that do the work; `more`: further packages."""
    found = {"Python": platform.python_version(), "Clew": commit()}
    return found | {package: metadata.version(package) for package in (*PACKAGES, *more)}


def commit() -> str:
    """The commit of this checkout; a `+` says that files differ from it."""
    try:
        said = subprocess.run(  # noqa: S603 - our own words
            ("git", "-C", str(ROOT), "describe", "--always", "--exclude=*", "--dirty=+"),  # noqa: S607 - any git
            capture_output=True,
            text=True,
            check=True,
        )
    except (OSError, subprocess.CalledProcessError):
        return "unknown"  # no checkout, or no git
    return said.stdout.strip()


def today() -> str:
    """The day (UTC)."""
    return datetime.now(UTC).date().isoformat()
