"""Debian's Chromium without a window, for tests of the page. It says all that its console and network did."""

import shutil
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass, field

import pytest
from playwright.sync_api import Browser, ConsoleMessage, Error, Page, Request, sync_playwright

CHROMIUM = shutil.which("chromium")
needs_chromium = pytest.mark.skipif(
    CHROMIUM is None, reason="no chromium here: apt-get install -y --no-install-recommends chromium"
)

FLAGS = (
    "--headless=new",
    "--no-sandbox",  # which root cannot have; it sees our own page and nothing else
    "--disable-gpu",
    "--disable-quic",
    "--no-first-run",
    "--disable-background-networking",
    "--disable-component-update",
    "--disable-sync",
)

WAIT_MS = 30_000.0  # for what comes within a second, on machines that are busy
WAIT = """new Promise((resolve, reject) => {
  const began = performance.now();
  const look = () => {
    if (%(condition)s) resolve();
    else if (performance.now() - began > %(ms)d) reject(Error("waited in vain"));
    else requestAnimationFrame(look);
  };
  look();
})"""
DESK = (1280, 800)
PHONE = (360, 740)  # the narrowest that is still sold


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
def chromium() -> Iterator[Browser]:
    """A browser with a profile of its own, which is gone when it is."""
    with sync_playwright() as playwright:
        browser = playwright.chromium.launch(executable_path=CHROMIUM, args=FLAGS)
        try:
            yield browser
        finally:
            browser.close()


@contextmanager
def sight(browser: Browser, *, size: tuple[int, int] = DESK, dark: bool = False) -> Iterator[Sight]:
    """A page of its own, as if nobody had ever opened one."""
    context = browser.new_context(
        viewport={"width": size[0], "height": size[1]}, color_scheme="dark" if dark else "light"
    )
    try:
        page = context.new_page()
        page.set_default_timeout(WAIT_MS)
        yield Sight(page)
    finally:
        context.close()
