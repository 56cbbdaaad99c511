"""What the parts of a fleet say on stderr while its table is shown: the launcher puts it into a file."""

from collections import deque
from pathlib import Path

PROGRESS = ("world: t=", "world: ok: ", "world: FAILED: ")
"""What the table shows itself, from the timeline; `output.py` leaves it out at the end, too."""
KEPT = 3  # lines: an address to open, and what has been started again


class Said:
    """The newest words in the file."""

    def __init__(self, path: Path) -> None:
        """Reads from the beginning, whenever there is a file."""
        self.newest: deque[str] = deque(maxlen=KEPT)
        self._path = path
        self._read_bytes = 0

    def look(self) -> bool:
        """Read what is new; returns whether there is anything to show."""
        try:
            with self._path.open("rb") as file:
                file.seek(self._read_bytes)
                text = file.read()
        except FileNotFoundError:  # the launcher has been killed, and we are about to hear of it
            return False
        whole = text[: text.rfind(b"\n") + 1]
        self._read_bytes += len(whole)
        words = [
            line for line in whole.decode(errors="replace").splitlines() if not line.startswith(PROGRESS)
        ]
        self.newest.extend(words)
        return bool(words)
