"""What a fleet's processes load before a robot can start."""

import subprocess
import sys

import pytest

from protocol.root import ROOT
from tests.support.deadline import DEADLINE_S


@pytest.mark.parametrize(
    ("process", "unused"),
    [
        ("world.__main__", "scipy"),
        ("clew.fleet.shell", "scipy"),
        ("agents.process.host", "scipy.ndimage"),
    ],
)
def test_no_process_of_a_fleet_loads_a_slow_library_that_it_seldom_needs(process: str, unused: str) -> None:
    said = subprocess.run(
        [sys.executable, "-c", f"import sys\nimport {process}\nprint({unused!r} in sys.modules)"],
        env={"PYTHONPATH": str(ROOT), "PYTHONSAFEPATH": "1"},
        capture_output=True,
        text=True,
        timeout=DEADLINE_S,
        check=True,
    )
    assert said.stdout == "False\n"
