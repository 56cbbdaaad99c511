"""Follows a tutorial from top to bottom: its files, its commands, and what it says that they print.

Rule 1: a line of three dots stands for any lines. Wall-clock times and the names of runs may differ.
Rule 2: commands that start real processes are passed over: their figures differ from run to run.
"""

import re
import shlex
from pathlib import Path

from tests.support.campaigns import clew
from tests.support.docs import page

BLOCK = re.compile(r"^```(\w*)\n(.*?)^```$", re.MULTILINE | re.DOTALL)
COMMAND = "$ ./launch/clew "
DIFFERS = {
    r"simulated in [\d.]+ s": "simulated in SOME s",
    r"runs/\d{8}T\d{6}Z-\w+-\w{4}": "runs/NAME",
}


class Tutorial:
    """A page of docs/tutorials, which is followed in the present folder."""

    def __init__(self, name: str) -> None:
        self._blocks = iter(BLOCK.findall(page(f"tutorials/{name}.md")))

    def save(self, name: str) -> None:
        """Save the next file that the page shows."""
        Path(name).write_text(self._next("toml"), encoding="utf-8")

    def append(self, name: str) -> None:
        """Append the next piece that the page shows to a file."""
        path = Path(name)
        path.write_text(f"{path.read_text(encoding='utf-8')}\n{self._next('toml')}", encoding="utf-8")

    def follow(self) -> None:
        """Run the commands of the next block: each prints what the page says."""
        for call in self._next("").split(COMMAND)[1:]:
            words, _, said = call.partition("\n")
            prints(shlex.split(words), said)

    def pass_over(self) -> None:
        """Take the next block as read (rule 2)."""
        self._next("")

    def end_with(self, *words: str) -> None:
        """Run a command that the text names: it ends as the next block says."""
        prints(words, f"...\n{self._next('')}")

    def _next(self, language: str) -> str:
        found, text = next(self._blocks)
        assert found == language, text
        return str(text)


def prints(words: list[str] | tuple[str, ...], said: str) -> None:
    """Check that a command prints what the page says (rule 1)."""
    printed, said = _alike(clew(*words).output), _alike(said).rstrip("\n") + "\n"
    pattern = re.sub(r"^(?:\\ )*\\\.\\\.\\\.\\\n", r"(?:.*\\n)*?", re.escape(said), flags=re.MULTILINE)
    assert re.fullmatch(pattern, printed), f"{shlex.join(words)} prints\n{printed}"


def _alike(text: str) -> str:
    for pattern, alike in DIFFERS.items():
        text = re.sub(pattern, alike, text)
    return text


def replace(name: str, old: str, new: str) -> None:
    """Change a file as the text of a tutorial says."""
    path = Path(name)
    text = path.read_text(encoding="utf-8")
    assert old in text
    path.write_text(text.replace(old, new), encoding="utf-8")
