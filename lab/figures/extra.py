"""What can be known of figures without matplotlib, which they need and nothing else does."""

from lab.extras import install_line
from protocol.errors import UsageError

FORMATS = ("svg", "pdf", "png")


def need_matplotlib() -> None:
    """Come back if figures can be drawn; called before any module that draws is imported.

    Raises:
        UsageError: matplotlib is not installed; it names the extra.
    """
    try:
        import matplotlib as mpl  # noqa: F401, PLC0415 - whether it is there; nobody else waits a second for it
    except ImportError as error:
        raise UsageError(f"figures need matplotlib, the extra `plot`: {install_line('plot')}") from error
