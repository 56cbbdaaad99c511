"""Every test in this folder starts a browser; it is skipped if there is none."""

from pathlib import Path

import pytest

from tests.support.pages.browser import needs_chromium


@pytest.hookimpl(tryfirst=True)  # before `-m` selects tests
def pytest_collection_modifyitems(items: list[pytest.Item]) -> None:
    for item in items:
        if item.path.is_relative_to(Path(__file__).parent):
            item.add_marker(pytest.mark.processes)
            item.add_marker(needs_chromium)
