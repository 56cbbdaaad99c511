"""The stderr of a fleet's parts while its table is shown: the launcher writes it to a file."""

import re
from collections import deque
from pathlib import Path

PROGRESS = re.compile(r"world: ([a-z][a-z0-9-]*: )?(t=|ok: |FAILED: )")
"""How a progress line begins, with the fleet's name where there are several. The table shows these itself;
`output.py` omits them at the end, too."""
KEPT = 3  # lines: an address to open, and restarts


class Said:
    """The newest lines in the file."""

    def __init__(self, path: Path) -> None:
        """Reads the file from its beginning, as soon as it exists."""
        self.newest: deque[str] = deque(maxlen=KEPT)
        self._path = path
        self._read_bytes = 0

    def look(self) -> bool:
        """Read new lines; returns whether there is anything new to show."""
        try:
            with self._path.open("rb") as file:
                file.seek(self._read_bytes)
                text = file.read()
        except FileNotFoundError:  # the launcher was killed, and our lifeline is about to end
            return False
        whole = text[: text.rfind(b"\n") + 1]
        self._read_bytes += len(whole)
        words = [line for line in whole.decode(errors="replace").splitlines() if not PROGRESS.match(line)]
        self.newest.extend(words)
        return bool(words)
