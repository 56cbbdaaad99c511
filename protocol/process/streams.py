"""Standard streams that the caller has closed, as with `>&-`, or whose reader goes away, as `head` does.

Rule 1: neither changes what a program does or its exit code: what is written goes nowhere.
"""

import os
import sys
from io import BufferedWriter, FileIO, TextIOWrapper
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from _typeshed import ReadableBuffer


def open_streams() -> None:
    """Open /dev/null in the place of each closed one: else the first file that is opened gets its number."""
    for number, name, mode in ((0, "stdin", "r"), (1, "stdout", "w"), (2, "stderr", "w")):
        try:
            os.fstat(number)
        except OSError:
            os.set_inheritable(os.open(os.devnull, os.O_RDWR), True)
            setattr(sys, name, os.fdopen(number, mode, encoding="utf-8"))


class _Outliving(FileIO):
    """A stream that may lose its reader."""

    reader_has_gone = False

    def write(self, data: "ReadableBuffer", /) -> int:
        """Write, or become /dev/null where the reader has gone: Python would report it again at exit."""
        try:
            return super().write(data)
        except BrokenPipeError:
            self.reader_has_gone = True
            with FileIO(os.devnull, "w") as nowhere:
                os.dup2(nowhere.fileno(), self.fileno())
            return super().write(data)


def outlive_readers() -> None:
    """Let stdout and stderr of this process lose their readers (rule 1); what replaced one of them stays."""
    for name in ("stdout", "stderr"):
        stream = getattr(sys, name)
        if stream is getattr(sys, f"__{name}__") and isinstance(stream, TextIOWrapper):
            stream.flush()
            outliving = TextIOWrapper(
                BufferedWriter(_Outliving(stream.fileno(), "w", closefd=False)),
                encoding=stream.encoding,
                errors=stream.errors,
                line_buffering=stream.line_buffering,
                write_through=stream.write_through,
            )
            setattr(sys, name, outliving)


def reader_has_gone() -> bool:
    """Whether a write has found that nobody reads stdout, so an endless verb may end."""
    return bool(getattr(getattr(getattr(sys.stdout, "buffer", None), "raw", None), "reader_has_gone", False))
