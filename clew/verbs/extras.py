"""Optional libraries: whether one is installed, and the command that installs it."""

import shlex
import sys
from importlib import import_module
from importlib.util import find_spec

from protocol.errors import UsageError
from protocol.root import IS_CHECKOUT, ROOT


def install_line(extra: str) -> str:
    """The command that installs an extra: of this checkout, or of the package, which stays as it is."""
    words = ["--editable", f"{ROOT}[{extra}]"] if IS_CHECKOUT else [f"clew[{extra}]"]
    ours = shlex.join(words)
    python = shlex.quote(sys.executable)
    if find_spec("pip") is None:  # as in an environment made by uv
        return f"uv pip install --python {python} {ours}"
    return f"{python} -m pip install {ours}"


def need(module: str, *, extra: str, by: str) -> None:
    """Check that a module can be imported.

    Raises:
        UsageError: it cannot; the message names the extra, and the command that installs it.
    """
    try:
        import_module(module)
    except ImportError as error:
        raise UsageError(f"{by} {module}, the extra `{extra}`: {install_line(extra)}") from error
