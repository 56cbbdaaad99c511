"""What the tests of forks share."""

from collections.abc import Iterator
from contextlib import suppress
from pathlib import Path

import pytest


def children() -> set[str]:
    """The processes that this one has started, and that it has not waited for."""
    found: set[str] = set()
    for task in Path("/proc/self/task").iterdir():
        with suppress(FileNotFoundError):  # a thread that has just ended
            found.update((task / "children").read_text().split())
    return found


@pytest.fixture
def no_child_is_left() -> Iterator[None]:
    """Afterwards no process is left that the test has started; other tests may have left some."""
    before = children()
    yield
    assert children() <= before
