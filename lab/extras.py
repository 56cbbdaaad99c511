"""How what this program does not need for a run is installed into the environment that it runs in."""

import shlex
import sys
from importlib.util import find_spec
from pathlib import Path

ROOT = Path(__file__).parents[1]


def install_line(extra: str) -> str:
    """The command line that brings an extra; an environment that uv has made holds no pip."""
    python, ours = shlex.quote(sys.executable), shlex.quote(f"{ROOT}[{extra}]")
    if find_spec("pip") is None:
        return f"uv pip install --python {python} --editable {ours}"
    return f"{python} -m pip install --editable {ours}"
