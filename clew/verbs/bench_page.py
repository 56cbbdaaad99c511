"""`clew bench page`: how fast the page of a long run opens, and how smoothly it is scrubbed."""

import tempfile
import time
from itertools import pairwise
from pathlib import Path

import click
import msgspec
from msgspec import Struct

from clew.page.document import document
from clew.page.serve.browser import chromium, window
from clew.rehearsal.recorded import rehearse
from clew.story.telling import Telling
from clew.verbs.options import AS_JSON
from world.scenario.scenario import Scenario

ROBOTS, RUN_S = 20, 600.0
SPEED_MPS = 0.5
FRAMES = 300  # over the whole run: 2 s of ten minutes each, which is fast scrubbing
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


class PageFigures(Struct, frozen=True, kw_only=True):
    """What was measured of one page."""

    robots: int
    run_s: float
    page_bytes: int
    pack_s: float
    """To make the page of the run's log."""
    open_s: float
    """Until the browser has drawn it first."""
    frames_per_s: float
    """While it is scrubbed through the whole run."""
    frame_ms_p95: float
    """Between two frames; 95 % are no further apart."""
    draw_ms: float
    """What the page's own code takes for a frame, in the median; the rest is the browser's."""


@click.command()
@click.argument("run", required=False, type=click.Path(path_type=Path))
@AS_JSON
def page(run: Path | None, *, as_json: bool) -> None:
    """Open the page of a run in Chromium and scrub it by a script, on this machine, without a graphics card.

    RUN is its folder; default: a rehearsal of 20 robots that takes ten minutes.
    """
    with tempfile.TemporaryDirectory() as scratch:
        if run is None:
            run = Path(scratch) / "run"
            run.mkdir()
            click.echo(f"rehearsing {ROBOTS} robots for {RUN_S:.0f} s", err=True)
            rehearse(avenue(), 1, run, lambda _: None)
        found = measure(run, Path(scratch) / "page.html")
    if as_json:
        click.echo(msgspec.json.encode(found).decode())
        return
    click.echo(
        f"{found.robots} robots, {found.run_s:.0f} s: a page of {found.page_bytes / 1e6:.2f} MB, "
        f"made in {found.pack_s:.1f} s, drawn after {found.open_s:.1f} s\n"
        f"scrubbed at {found.frames_per_s:.0f} frames a second, 95 % within {found.frame_ms_p95:.0f} ms; "
        f"its own code takes {found.draw_ms:.1f} ms of a frame"
    )


def measure(run: Path, file: Path) -> PageFigures:
    """Make the page of a run, open it and scrub it."""
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
    gaps_ms = sorted(after - before for before, after in pairwise(times_ms))
    return PageFigures(
        robots=robots,
        run_s=run_s,
        page_bytes=file.stat().st_size,
        pack_s=packed_s - began_s,
        open_s=opened_s - opens_s,
        frames_per_s=1000.0 * len(gaps_ms) / (times_ms[-1] - times_ms[0]),
        frame_ms_p95=gaps_ms[int(0.95 * len(gaps_ms))],
        draw_ms=draw_ms,
    )


def avenue() -> Scenario:
    """A way between two rows of trees that is as long as the robots drive in the time."""
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
