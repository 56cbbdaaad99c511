"""A terminal for tests: a pseudo-terminal for processes, and the screen that its user sees."""

import fcntl
import os
import re
import select
import struct
import termios
import time
from collections import deque
from dataclasses import dataclass, field

import pyte

from tests.support.deadline import DEADLINE_S

CTRL_C = b"\x03"
READ_S = 0.05
PICTURE = re.compile(rb"(?=\r\x1b\[2K\x1b\[1A)")  # Rich removes the last picture before it draws the next one


@dataclass(slots=True)
class Terminal:
    """The user's end of a pseudo-terminal."""

    columns: int = 100
    lines: int = 30
    written: bytes = b""
    """Everything that was ever written to it."""
    theirs: int = field(init=False)
    """The end for a process."""
    _ours: int = field(init=False)
    _screen: pyte.Screen = field(init=False)
    _stream: pyte.ByteStream = field(init=False)
    _coming: deque[bytes] = field(default_factory=deque)
    """Pictures that are not on the screen yet: a test that is late misses none."""

    def __post_init__(self) -> None:
        self._ours, self.theirs = os.openpty()
        size = struct.pack("HHHH", self.lines, self.columns, 0, 0)
        fcntl.ioctl(self._ours, termios.TIOCSWINSZ, size)
        self._screen = pyte.Screen(self.columns, self.lines)
        self._stream = pyte.ByteStream(self._screen)

    def begin(self) -> None:
        """Close our copy of the process's end: now only the process keeps the terminal open."""
        os.close(self.theirs)

    @property
    def text(self) -> str:
        """The text on the screen."""
        return "\n".join(line.rstrip() for line in self._screen.display).rstrip()

    def hides_its_cursor(self) -> bool:
        return bool(self._screen.cursor.hidden)

    def press(self, keys: bytes) -> None:
        os.write(self._ours, keys)

    def read(self) -> bool:
        """Show the next picture that was written; False if no process has the other end any more."""
        if not self._coming:
            if not select.select([self._ours], [], [], READ_S)[0]:
                return True
            try:
                text = os.read(self._ours, 65536)
            except OSError:  # EIO: the terminal's other end is closed
                return False
            self.written += text
            self._coming.extend(filter(None, PICTURE.split(text)))
        self._stream.feed(self._coming.popleft())
        return True

    def wait_for(self, words: str, timeout_s: float = DEADLINE_S) -> str:
        """Wait until these words are on the screen; returns its text."""
        deadline_s = time.monotonic() + timeout_s
        while words not in self.text:
            assert self.read(), f"all processes are gone without having printed {words!r}:\n{self.text}"
            assert time.monotonic() < deadline_s, f"waited {timeout_s} s for {words!r}:\n{self.text}"
        return self.text

    def read_to_the_end(self, timeout_s: float = DEADLINE_S) -> None:
        """Wait until no process has the other end any more."""
        deadline_s = time.monotonic() + timeout_s
        while self.read():
            assert time.monotonic() < deadline_s, f"waited {timeout_s} s for the end:\n{self.text}"

    def close(self) -> None:
        os.close(self._ours)
