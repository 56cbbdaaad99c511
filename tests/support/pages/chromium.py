"""Headless Chromium, driven by playwright: for tests of the page, its pictures and its bench."""

import shutil
from collections.abc import Iterator
from contextlib import contextmanager

from playwright.sync_api import Browser, Page, sync_playwright

CHROMIUM = shutil.which("chromium")
INSTALL = "apt-get install -y --no-install-recommends chromium"

FLAGS = (
    "--headless=new",
    "--no-sandbox",  # root cannot have a sandbox; this browser shows our own page and nothing else
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
def chromium() -> Iterator[Browser]:
    """A browser with a new profile, which is removed at the end."""
    if CHROMIUM is None:
        raise SystemExit(f"no chromium here: {INSTALL}")
    with sync_playwright() as playwright:
        browser = playwright.chromium.launch(executable_path=CHROMIUM, args=FLAGS)
        try:
            yield browser
        finally:
            browser.close()


@contextmanager
def window(browser: Browser, *, size: tuple[int, int] = DESK, dark: bool = False) -> Iterator[Page]:
    """A page that shares no state with other pages."""
    context = browser.new_context(
        viewport={"width": size[0], "height": size[1]}, color_scheme="dark" if dark else "light"
    )
    try:
        yield context.new_page()
    finally:
        context.close()
