"""What stands in the pages of docs/."""

import re

from protocol.root import ROOT


def page(name: str) -> str:
    """The text of a page."""
    return (ROOT / "docs" / name).read_text(encoding="utf-8")


def example(name: str, language: str = "toml") -> str:
    """The first block of code of this language in a page."""
    return page(name).split(f"```{language}\n")[1].split("```")[0]


def explained(name: str, begins: str, ends: str) -> list[str]:
    """The names in the first columns of the tables of a page, between two texts, in their order."""
    part = page(name).split(begins, 1)[1].split(ends, 1)[0]
    rows = re.findall(r"^\| (`.*?) \|", part, re.MULTILINE)
    return [field for row in rows for field in re.findall(r"`(\w+)`", row)]
