"""The docs name only files, functions and tests that exist, and numbers as they are."""

import re
from collections.abc import Iterator
from pathlib import Path

from agents.liveness import presence, suspicion
from agents.liveness.timing import Timing
from agents.membership import pleas
from agents.strand import blocked, member
from protocol.root import ROOT
from tests.support.docs import page
from world import quota
from world.bodies import fence

STRAND = "strand.md"
WORDS_MAX = 1800  # of the page on the protocol: it is read from start to end
ROOTS = ("agents", "clew", "launch", "protocol", "tests", "world")


def pages() -> list[Path]:
    return [ROOT / "README.md", *sorted((ROOT / "docs").rglob("*.md"))]


def paths_in(text: str) -> set[str]:
    """Files of ours that a text names in backticks, by their paths."""
    named = re.findall(rf"`((?:{'|'.join(ROOTS)})/[\w/.-]+\.(?:py|js|toml|sh))\b", text)
    return {name for name in named if "*" not in name}


def kept_by(text: str) -> Iterator[tuple[str, list[str]]]:
    """What a text names as `file: name, name`: the file, by its path or its name alone, and the names."""
    for file, names in re.findall(r"`([\w/]+\.py): ([\w., ]+)`", text):
        yield file, [part for name in names.split(", ") for part in name.split(".")]


def sources(file: str) -> list[str]:
    found = (
        ROOT.glob(file)
        if file.startswith(ROOTS)
        else [*ROOT.glob(f"agents/**/{file}"), *ROOT.glob(f"tests/**/{file}")]
    )
    return [path.read_text(encoding="utf-8") for path in found]


def test_every_file_that_a_page_names_exists() -> None:
    dead = [
        (path.name, name)
        for path in pages()
        for name in sorted(paths_in(path.read_text(encoding="utf-8")))
        if path.name != "measured.md" and not (ROOT / name).exists()
    ]
    assert dead == []


def test_no_page_has_a_mark_of_a_merge_that_was_not_resolved() -> None:
    mark = re.compile("^(<{7}|>{7}) ", re.MULTILINE)
    found = [path.name for path in pages() if mark.search(path.read_text(encoding="utf-8"))]
    assert found == []


def test_everything_that_keeps_a_rule_and_every_test_of_it_exists() -> None:
    named = list(kept_by(page(STRAND)))
    assert len(named) >= 20
    missing = [
        (file, name)
        for file, names in named
        for name in names
        if not any(re.search(rf"(?:def|class) {name}\b", source) for source in sources(file))
    ]
    assert missing == []


def test_the_page_on_the_protocol_is_short() -> None:
    assert len(page(STRAND).split()) <= WORDS_MAX


def test_the_page_on_the_protocol_has_the_numbers_of_liveness() -> None:
    table = page(STRAND).split("\n## Liveness")[1].split("\n## ")[0]
    told = {float(number) for number in re.findall(r"\d+(?:\.\d+)?", table)}
    timing = Timing()
    kept = {getattr(timing, name) for name in Timing.__dataclass_fields__}
    kept |= {presence.GRACE_S, suspicion.HALF_LIFE_S, suspicion.SUPPRESS}
    kept |= {pleas.STOP_S, fence.OUTSIDERS_S, member.IN_VAIN_MAX}
    kept |= {quota.RAISES_MAX, quota.BACK_S, quota.BACK_S_MAX, blocked.BLOCKED_S}
    assert {float(value) for value in kept} <= told
