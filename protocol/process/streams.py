"""Standard streams that the caller has closed, as with `>&-`."""

import os
import sys


def open_streams() -> None:
    """Open /dev/null in the place of each closed one: else the first file that is opened gets its number."""
    for number, name, mode in ((0, "stdin", "r"), (1, "stdout", "w"), (2, "stderr", "w")):
        try:
            os.fstat(number)
        except OSError:
            os.set_inheritable(os.open(os.devnull, os.O_RDWR), True)
            setattr(sys, name, os.fdopen(number, mode, encoding="utf-8"))
