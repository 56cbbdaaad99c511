"""Pages for tests: what a report holds of them, read again as the page's script does."""

import base64
import gzip
import json
import re
from itertools import accumulate
from pathlib import Path
from typing import Any

from clew.page.document import document
from clew.page.telling import Telling

STORY = re.compile(r'<script type="text/plain" id="story">([^<]*)</script>')


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
