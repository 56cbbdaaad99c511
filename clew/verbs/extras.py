"""What this program does not need for a run: whether it is there, and how it is installed where we run."""

import shlex
import sys
from importlib import import_module
from importlib.util import find_spec

from protocol.errors import UsageError
from protocol.root import ROOT


def install_line(extra: str) -> str:
    """The command line that brings an extra; an environment that uv has made holds no pip."""
    python, ours = shlex.quote(sys.executable), shlex.quote(f"{ROOT}[{extra}]")
    if find_spec("pip") is None:
        return f"uv pip install --python {python} --editable {ours}"
    return f"{python} -m pip install --editable {ours}"


def need(module: str, *, extra: str, by: str) -> None:
    """Come back if a module can be imported; called before any of ours that imports it is.

    Raises:
        UsageError: it cannot; it names who needs it, and the extra that brings it.
    """
    try:
        import_module(module)
    except ImportError as error:
        raise UsageError(f"{by} {module}, the extra `{extra}`: {install_line(extra)}") from error
