"""Sessions of pytest with our plugin, for tests of it."""

import os
import subprocess
import sys
from pathlib import Path

from protocol.root import ROOT
from tests.support.deadline import DEADLINE_S

HEAD = "import clew\nimport pytest\n\n"


def played(folder: Path, test: str, *options: str) -> tuple[int, str]:
    """Run a file of tests with the plugin; returns the exit code and the output."""
    (folder / "test_mine.py").write_text(HEAD + test, encoding="utf-8")
    said = subprocess.run(
        [sys.executable, "-m", "pytest", "-p", "clew.pytest_plugin", "-p", "xdist", *options],
        cwd=folder,
        env={
            **{name: value for name, value in os.environ.items() if not name.startswith("PYTEST_")},
            "PYTHONPATH": str(ROOT),
            "PYTEST_DISABLE_PLUGIN_AUTOLOAD": "1",  # the environment may have an older one of ours
        },
        capture_output=True,
        text=True,
        timeout=2 * DEADLINE_S,
        check=False,
    )
    return said.returncode, said.stdout + said.stderr
