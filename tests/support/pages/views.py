"""Starts viewers for tests and reads their events as a page does."""

import http.client
import json
import os
import re
import subprocess
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import IO, Any

from protocol.root import ROOT
from tests.support.deadline import DEADLINE_S


@contextmanager
def view(*arguments: str | Path, cwd: Path) -> Iterator[subprocess.Popen[str]]:
    """A viewer, which always ends with the context."""
    with subprocess.Popen(
        [sys.executable, "-m", "clew.cli", "view", *arguments],
        cwd=cwd,
        env={**os.environ, "PYTHONPATH": str(ROOT)},
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
    ) as viewer:
        try:
            yield viewer
        finally:
            viewer.kill()


def address_of(said: IO[str] | None) -> str:
    """The page's address, as soon as the viewer prints it."""
    assert said is not None
    heard = []
    for text in said:
        heard.append(text)
        if (match := re.search(r"http://\S+", text)) is not None:
            return match.group()
    raise AssertionError(f"no address in {heard}")


def told(address: str, run: int = 0) -> Iterator[dict[str, Any]]:
    """The batches that a page receives until the viewer has ended."""
    connection = http.client.HTTPConnection(address.removeprefix("http://").rstrip("/"), timeout=DEADLINE_S)
    connection.request("GET", f"/events/{run}")
    with connection.getresponse() as response:
        for text in response:
            if text.startswith(b"data: "):
                yield json.loads(text.removeprefix(b"data: "))
