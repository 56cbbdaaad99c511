"""What a new process of Python has loaded."""

import subprocess
import sys

from protocol.root import ROOT
from tests.support.deadline import DEADLINE_S


def loaded(script: str) -> set[str]:
    """The modules that a script has loaded at its end."""
    said = subprocess.run(
        [sys.executable, "-c", f"import sys\n{script}\nprint(*sys.modules)"],
        env={"PYTHONPATH": str(ROOT), "PYTHONSAFEPATH": "1"},
        capture_output=True,
        text=True,
        timeout=DEADLINE_S,
        check=True,
    )
    return set(said.stdout.split())
