"""Takes the pictures of the page in docs/.

They show the report of a rehearsal in which the leader is killed (light, dark, on a phone), and a live fleet.

    python -m tests.support.pages.pictures [FOLDER]
"""

import re
import signal
import subprocess
import sys
import tempfile
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from playwright.sync_api import Page

from clew.page.document import document
from clew.page.telling import Telling
from clew.rehearsal.recorded import rehearse
from protocol.faults.plan import load as load_plan
from protocol.root import ROOT
from tests.support.pages.chromium import PHONE, chromium, window
from world.scenario.scenario import load

SCENARIO, PLAN, SEED = "grove", "leader-killed", 1
MOMENT = "#t=12.6&robot=2"  # the second leader drives around the body of the first
LIVE_S = 9.0  # simulated, of the live fleet
SIZE = (1280, 1100)  # shows the whole map
REACHED = f"new Promise((done) => setInterval(() => clew.time > {LIVE_S} && done(), 20))"
DRAWN = "new Promise((done) => requestAnimationFrame(() => requestAnimationFrame(done)))"


def pictures(docs: Path, scratch: Path) -> Iterator[Path]:
    """Take all pictures; yields the path of each."""
    report = scratch / "report.html"
    run = scratch / "run"
    rehearse(load(SCENARIO, seed=SEED), SEED, run, lambda _: None, load_plan(PLAN))
    report.write_text(document([Telling(run).batches()]), encoding="utf-8")
    address = f"{report.as_uri()}{MOMENT}"
    with chromium() as browser:
        for name, size, height, dark in (
            ("report", SIZE, SIZE[1], False),
            ("report-dark", SIZE, SIZE[1], True),
            ("report-phone", PHONE, 2 * PHONE[1], False),  # scrolled down once
        ):
            with window(browser, size=size, dark=dark) as page:
                page.goto(address)
                yield _taken(page, docs / f"{name}.png", height)
        with fleet(scratch / "live") as live, window(browser, size=SIZE) as page:
            page.goto(live)
            page.evaluate(REACHED)
            yield _taken(page, docs / "view-live.png", SIZE[1])


def _taken(page: Page, path: Path, height: int) -> Path:
    page.evaluate(DRAWN)
    width = page.viewport_size["width"] if page.viewport_size else 0
    page.screenshot(path=path, full_page=True, clip={"x": 0, "y": 0, "width": width, "height": height})
    return path


@contextmanager
def fleet(run: Path) -> Iterator[str]:
    """The address of the page of a live fleet."""
    with subprocess.Popen(
        [ROOT / "launch" / "fleet.sh", SCENARIO, "--seed", str(SEED), "--view", "--out", run],
        stdout=subprocess.DEVNULL,
        stderr=subprocess.PIPE,
        text=True,
    ) as launcher:
        try:
            assert launcher.stderr is not None
            found = (re.search(r"http://\S+", line) for line in launcher.stderr)
            yield next(match.group() for match in found if match is not None)
        finally:
            launcher.send_signal(signal.SIGINT)


if __name__ == "__main__":
    with tempfile.TemporaryDirectory() as scratch_folder:
        for picture in pictures(Path(sys.argv[1] if len(sys.argv) > 1 else "docs"), Path(scratch_folder)):
            sys.stdout.write(f"{picture}\n")
