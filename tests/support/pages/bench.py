"""How fast the report page of a long run opens, and how smoothly it is scrubbed.

    python -m tests.support.pages.bench [RUN]

RUN is a run's folder; default: a rehearsal of 20 robots that takes ten minutes. Chromium opens the page
without a graphics card.
"""

import sys
import tempfile
import time
from itertools import pairwise
from pathlib import Path

import msgspec

from clew.page.document import document
from clew.page.telling import Telling
from clew.percentiles import percentile
from clew.rehearsal.recorded import rehearse
from tests.support.pages.chromium import chromium, window
from world.scenario.scenario import Scenario

ROBOTS, RUN_S = 20, 600.0
SPEED_MPS = 0.5
FRAMES = 300  # over the whole run: each frame moves on by 2 s of the ten minutes, which is fast scrubbing
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
    """Make the page of a run, open it and scrub it; returns the figures in words."""
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


def avenue() -> Scenario:
    """A way between two rows of trees, as long as the robots drive in RUN_S."""
    length_m = RUN_S * SPEED_MPS
    trees = [
        {"shape": "circle", "centre_m": [5.0 * place, 2.0 + 2.2 * (place % 2)], "radius_m": 0.5}
        for place in range(1, int(length_m / 5.0))
    ]
    return msgspec.convert(
        {
            "name": "avenue",
            "fleet": {
                "robots": ROBOTS,
                "robot_radius_m": 0.15,
                "start": [-0.5, 3.0, 0.0],
                "spacing_m": 0.5,
                "separation_m": 0.05,
                "link_length_m_max": 2.0,
            },
            "law": {"law": "certified", "epsilon_m": 0.1, "mu0_m": 0.01},
            "goal": {"at_m": [length_m, 3.0], "tolerance_m": 0.3},
            "bounds": {"x_m_min": -12.0, "x_m_max": length_m + 2.0, "y_m_min": 0.0, "y_m_max": 6.0},
            "sensor": {"directions": 720, "range_m_max": 6.0, "range_sigma_m": 0.001},
            "drive": {
                "speed_mps": SPEED_MPS,
                "speed_mps_min": 0.05,
                "speed_mps_max": 1.0,
                "turn_rate_radps": 1.5708,
                "heading_error_rad": 0.0003,
            },
            "time": {"time_s_max": 2.0 * RUN_S},
            "obstacle": trees,
        },
        Scenario,
    )


def main() -> None:
    """Measure the run that the command line names, or a new rehearsal."""
    with tempfile.TemporaryDirectory() as scratch:
        run = Path(sys.argv[1]) if len(sys.argv) > 1 else Path(scratch) / "run"
        if len(sys.argv) == 1:
            run.mkdir()
            sys.stderr.write(f"rehearsing {ROBOTS} robots for {RUN_S:.0f} s\n")
            rehearse(avenue(), 1, run, lambda _: None)
        sys.stdout.write(measure(run, Path(scratch) / "page.html") + "\n")


if __name__ == "__main__":
    main()
