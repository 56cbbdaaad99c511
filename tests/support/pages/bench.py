"""How fast the report page of a long run opens, and how smoothly it is scrubbed.

    python -m tests.support.pages.bench RUN

RUN is a run's folder. Chromium opens the page without a graphics card.
"""

import sys
import tempfile
import time
from itertools import pairwise
from pathlib import Path

from clew.page.document import document
from clew.page.telling import Telling
from clew.percentiles import percentile
from tests.support.pages.chromium import chromium, window

FRAMES = 300  # over the whole run: of ten minutes each frame advances by 2 s, which is fast scrubbing
SCRUB = """new Promise((done) => {
  const end = clew.runs[0].end, times = [];
  const tick = (now) => {
    times.push(now);
    if (times.length > FRAMES) return done(times);
    clew.seek((end * times.length) / FRAMES);
    requestAnimationFrame(tick);
  };
  requestAnimationFrame(tick);
})""".replace("FRAMES", str(FRAMES))
DRAW = """(() => {
  const took = [];
  for (let frame = 0; frame < FRAMES; frame++) {
    clew.seek((clew.runs[0].end * frame) / FRAMES);
    const began = performance.now();
    clew.draw();
    took.push(performance.now() - began);
  }
  return took.sort((a, b) => a - b)[FRAMES >> 1];
})()""".replace("FRAMES", str(FRAMES))


def measure(run: Path, file: Path) -> str:
    """Make the page of a run, open it and scrub it; returns the figures as text."""
    began_s = time.perf_counter()
    file.write_text(document([Telling(run).batches()]), encoding="utf-8")
    packed_s = time.perf_counter()
    with chromium() as browser, window(browser) as shown:
        opens_s = time.perf_counter()
        shown.goto(file.as_uri())
        shown.evaluate("clew.opened.then(() => clew.draw())")
        opened_s = time.perf_counter()
        times_ms = shown.evaluate(SCRUB)
        draw_ms = shown.evaluate(DRAW)
        run_s, robots = shown.evaluate("[clew.runs[0].end, clew.runs[0].bodies.size]")
    gaps_ms = [after - before for before, after in pairwise(times_ms)]
    frames_per_s = 1000.0 * len(gaps_ms) / (times_ms[-1] - times_ms[0])
    return (
        f"{robots} robots, {run_s:.0f} s: a page of {file.stat().st_size / 1e6:.2f} MB, made in "
        f"{packed_s - began_s:.1f} s, drawn after {opened_s - opens_s:.1f} s; scrubbed at {frames_per_s:.0f} "
        f"frames a second, 95 % within {percentile(gaps_ms, 95):.0f} ms; the page's own code takes "
        f"{draw_ms:.1f} ms of a frame (median)"
    )


if __name__ == "__main__":
    with tempfile.TemporaryDirectory() as scratch:
        sys.stdout.write(measure(Path(sys.argv[1]), Path(scratch) / "page.html") + "\n")
