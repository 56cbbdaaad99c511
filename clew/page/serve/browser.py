"""Debian's Chromium without a window: for pictures of the page, its tests and its bench.

Playwright drives it, from the extra `dev`: it tells of the console and of every request, and drives whatever
Chromium is there, where selenium wants a driver of the same version beside it.
"""

import shutil
from collections.abc import Iterator
from contextlib import contextmanager
from typing import TYPE_CHECKING

from protocol.errors import UsageError

if TYPE_CHECKING:
    from playwright.sync_api import Browser, Page

CHROMIUM = shutil.which("chromium")
INSTALL = "apt-get install -y --no-install-recommends chromium"

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

DESK = (1280, 800)
PHONE = (360, 740)  # the narrowest that is still sold


@contextmanager
def chromium() -> Iterator["Browser"]:
    """A browser with a profile of its own, which is gone when it is.

    Raises:
        UsageError: there is none.
    """
    try:
        from playwright.sync_api import sync_playwright  # noqa: PLC0415 - nobody else needs it, or has it
    except ImportError as error:
        raise UsageError("playwright is not installed: it comes with the extra `dev`") from error
    if CHROMIUM is None:
        raise UsageError(f"no chromium here: {INSTALL}")
    with sync_playwright() as playwright:
        browser = playwright.chromium.launch(executable_path=CHROMIUM, args=FLAGS)
        try:
            yield browser
        finally:
            browser.close()


@contextmanager
def window(browser: "Browser", *, size: tuple[int, int] = DESK, dark: bool = False) -> Iterator["Page"]:
    """A page of its own, as if nobody had ever opened one."""
    context = browser.new_context(
        viewport={"width": size[0], "height": size[1]}, color_scheme="dark" if dark else "light"
    )
    try:
        yield context.new_page()
    finally:
        context.close()
