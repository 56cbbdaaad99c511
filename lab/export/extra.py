"""Whether what an export needs is installed."""

from importlib import import_module

from lab.extras import install_line
from protocol.errors import UsageError


def need(module: str, *, extra: str) -> None:
    """Come back if a module can be imported.

    Raises:
        UsageError: it cannot; it names the extra that brings it.
    """
    try:
        import_module(module)
    except ImportError as error:
        raise UsageError(f"this export needs {module}, the extra `{extra}`: {install_line(extra)}") from error
