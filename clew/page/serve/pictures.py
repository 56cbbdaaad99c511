"""The pictures of the page in docs/: `python -m clew.page.serve.pictures`, with chromium and the extra `dev`.

The report of a rehearsal in which the leader is killed, light, dark and on a phone; and a live fleet.
"""

import argparse
import re
import signal
import subprocess
import sys
import tempfile
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING

from clew.page.document import document
from clew.page.serve.browser import PHONE, chromium, window
from clew.rehearsal.recorded import rehearse
from clew.story.telling import Telling
from protocol.errors import UsageError
from protocol.exit_codes import ExitCode
from protocol.faults.plan import load as load_plan
from protocol.root import ROOT
from world.scenario.scenario import load

if TYPE_CHECKING:
    from playwright.sync_api import Page

LAUNCHER = ROOT / "launch" / "fleet.sh"

SCENARIO, PLAN, SEED = "grove", "leader-killed", 1
MOMENT = "#t=12.6&robot=2"  # the second leader is on its way, round the body of the first
LIVE_S = 9.0  # simulated, of the fleet that is shown live
SIZE = (1280, 1100)  # the whole map is seen
REACHED = f"new Promise((done) => setInterval(() => clew.time > {LIVE_S} && done(), 20))"
DRAWN = "new Promise((done) => requestAnimationFrame(() => requestAnimationFrame(done)))"


def pictures(docs: Path, scratch: Path) -> Iterator[Path]:
    """Take them all; says each when it is there."""
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


def _taken(page: "Page", path: Path, height: int) -> Path:
    page.evaluate(DRAWN)
    width = page.viewport_size["width"] if page.viewport_size else 0
    page.screenshot(path=path, full_page=True, clip={"x": 0, "y": 0, "width": width, "height": height})
    return path


@contextmanager
def fleet(run: Path) -> Iterator[str]:
    """The address at which a fleet shows itself."""
    with subprocess.Popen(  # noqa: S603 - the launcher is our own
        [LAUNCHER, SCENARIO, "--seed", str(SEED), "--view", "--out", run],
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


def main(arguments: Sequence[str]) -> int:
    """Take the pictures; returns the exit code."""
    parser = argparse.ArgumentParser(prog="python -m clew.page.serve.pictures", description=__doc__)
    parser.add_argument("folder", nargs="?", default=Path("docs"), type=Path, help="default: %(default)s")
    docs = parser.parse_args(arguments).folder
    try:
        with tempfile.TemporaryDirectory() as scratch:
            for path in pictures(docs, Path(scratch)):
                sys.stdout.write(f"{path}\n")
    except UsageError as error:
        sys.stderr.write(f"pictures: {error}\n")
        return ExitCode.USAGE
    return 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
