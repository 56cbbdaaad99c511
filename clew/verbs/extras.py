"""Optional libraries: whether one is installed, and the command that installs it."""

import shlex
import sys
from importlib import import_module
from importlib.util import find_spec

from protocol.errors import UsageError
from protocol.root import IS_CHECKOUT, ROOT


def install_line(extra: str) -> str:
    """The command that installs an extra. An environment made by uv has no pip."""
    place = ROOT if IS_CHECKOUT else "PATH-OF-A-CHECKOUT"
    python, ours = shlex.quote(sys.executable), shlex.quote(f"{place}[{extra}]")
    if find_spec("pip") is None:
        return f"uv pip install --python {python} --editable {ours}"
    return f"{python} -m pip install --editable {ours}"


def need(module: str, *, extra: str, by: str) -> None:
    """Check that a module can be imported.

    Raises:
        UsageError: it cannot; the message names the extra, and the command that installs it.
    """
    try:
        import_module(module)
    except ImportError as error:
        raise UsageError(f"{by} {module}, the extra `{extra}`: {install_line(extra)}") from error
