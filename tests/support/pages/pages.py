"""Pages for tests: rehearsed runs, and what a report holds of them, read again as the page's script does."""

import base64
import gzip
import json
import re
from itertools import accumulate
from pathlib import Path
from typing import Any

from clew.page.document import document
from clew.page.telling import Telling
from clew.rehearsal.recorded import rehearse
from protocol.faults.plan import load as load_plan
from world.scenario.scenario import load

STORY = re.compile(r'<script type="text/plain" id="story">([^<]*)</script>')


def rehearsed(folder: Path, scenario: str, *, faults: str = "", seed: int = 1) -> Path:
    """The folder of a run."""
    folder.mkdir()
    plan = [load_plan(faults)] if faults else []
    rehearse(load(scenario), seed, folder, lambda _: None, *plan)
    return folder


def told(run: Path) -> list[dict[str, Any]]:
    """The batches of a run."""
    return [json.loads(batch) for batch in Telling(run).batches()]


def page_of(run: Path) -> str:
    """The report of a run."""
    return document([Telling(run).batches()])


def inlined(page: str) -> list[dict[str, Any]]:
    """The batches that stand in a page of one run."""
    match = STORY.search(page)
    assert match is not None
    lines = gzip.decompress(base64.b64decode(match[1])).splitlines()
    return [batch for index, batch in map(json.loads, lines) if index == 0]


def column(deltas: list[int], per_unit: float) -> list[float]:
    """A column as the page reads it."""
    return [value / per_unit for value in accumulate(deltas)]
