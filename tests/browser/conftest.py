"""Every test in this folder starts a browser; it is skipped if there is none."""

from collections.abc import Iterator
from pathlib import Path

import pytest
from playwright.sync_api import Browser

from tests.support.pages.browser import needs_chromium
from tests.support.pages.chromium import chromium


@pytest.fixture(scope="package")  # while it lives, no other test of the worker could run an event loop
def browser() -> Iterator[Browser]:
    """One browser for the tests of this folder that a worker runs in a row: its pages share nothing."""
    with chromium() as browser:
        yield browser


@pytest.hookimpl(tryfirst=True)  # before `-m` selects tests
def pytest_collection_modifyitems(items: list[pytest.Item]) -> None:
    for item in items:
        if item.path.is_relative_to(Path(__file__).parent):
            item.add_marker(pytest.mark.processes)
            item.add_marker(needs_chromium)
