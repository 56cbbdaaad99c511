"""`clew bench soak`, small: a live fleet whose robots are killed and started again."""

import subprocess
import sys
from pathlib import Path

import msgspec
import pytest

from clew.bench.result import Result
from clew.bench.soak import PARTS, Soak
from protocol.exit_codes import ExitCode
from tests.support.deadline import DEADLINE_S

WORDS = ("-n", "5", "--for-s", "6", "--every-s", "2", "--probe-s", "2", "--look-s", "1", "--json")


@pytest.mark.long
def test_robots_die_and_come_back_and_what_they_cost_is_measured(tmp_path: Path) -> None:
    command = [sys.executable, "-m", "clew.cli", "bench", "soak", *WORDS, "--keep", str(tmp_path)]
    ended = subprocess.run(command, capture_output=True, text=True, timeout=4 * DEADLINE_S, check=False)
    # In its first seconds a fleet grows, so a bound of memory may be passed.
    assert ended.returncode in (ExitCode.OK, ExitCode.FAILED), ended.stderr
    result = msgspec.json.decode(ended.stdout, type=Result)
    soak = msgspec.convert(result.details, Soak)
    assert (soak.missing, soak.violations, soak.said) == (0, 0, "the run was told to end"), ended.stderr
    assert soak.restarts >= 2
    assert all(probe.took_s is not None for probe in soak.probes)
    assert max(look.sessions for look in soak.looks) >= 5
    assert all(set(look.used) == set(PARTS) for look in soak.looks)
    assert {"probes refused", "sessions at the router, growth"} <= {each.name for each in result.figures}
