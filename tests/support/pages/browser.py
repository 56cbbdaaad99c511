"""A browser for tests of the page, which says all that its console and network did."""

from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass, field

import pytest
from playwright.sync_api import Browser, ConsoleMessage, Error, Page, Request

from tests.support.deadline import DEADLINE_S
from tests.support.pages.chromium import CHROMIUM, DESK, INSTALL, window

needs_chromium = pytest.mark.skipif(CHROMIUM is None, reason=f"no chromium here: {INSTALL}")

WAIT_MS = 1000.0 * DEADLINE_S
WAIT = """new Promise((resolve, reject) => {
  const began = performance.now();
  const look = () => {
    if (%(condition)s) resolve();
    else if (performance.now() - began > %(ms)d) reject(Error("waited in vain"));
    else requestAnimationFrame(look);
  };
  look();
})"""


@dataclass  # without slots: playwright leaves a note in whoever listens
class Sight:
    """One page in a browser, and what it did beside being shown."""

    page: Page
    troubles: list[str] = field(default_factory=list)
    """Errors and warnings of its console, and exceptions that nobody caught."""
    requests: list[str] = field(default_factory=list)

    def __post_init__(self) -> None:
        self.page.on("console", self._hear)
        self.page.on("pageerror", self._fail)
        self.page.on("request", self._request)

    def _hear(self, message: ConsoleMessage) -> None:
        if message.type in {"error", "warning"}:
            self.troubles.append(message.text)

    def _fail(self, error: Error) -> None:
        self.troubles.append(str(error))

    def _request(self, request: Request) -> None:
        self.requests.append(request.url)

    def show(self, url: str) -> None:
        """Go there, and wait until something of a run is shown."""
        self.page.goto(url)
        self.wait("clew.frames > 0 && clew.runs.length > 0")

    def wait(self, condition: str) -> None:
        """Until this JavaScript is true. Playwright's own way needs `unsafe-eval`, which our page forbids."""
        try:
            self.page.evaluate(WAIT % {"condition": condition, "ms": WAIT_MS})
        except Error as error:
            if "navigation" not in error.message:
                raise
            self.page.wait_for_load_state()  # the page has loaded itself again
            self.wait(condition)


@contextmanager
def sight(browser: Browser, *, size: tuple[int, int] = DESK, dark: bool = False) -> Iterator[Sight]:
    """A page of its own."""
    with window(browser, size=size, dark=dark) as page:
        page.set_default_timeout(WAIT_MS)
        yield Sight(page)
