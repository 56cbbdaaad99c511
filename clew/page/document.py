"""The page as a single file: markup, styles, scripts and, in a report, the runs. It requests nothing.

    document([batches_of_a_run, ...])                # a report: opens from file://
    document(scripts=(FEED,), connects=True)         # served: a script calls `clew.take(run_index, batch)`

Rule 1: the scripts form one function, in the order of `SCRIPTS`; each script sees the names of earlier ones.
Rule 2: the browser itself refuses requests. The content security policy allows none; a served page may only
        send requests to its own origin.
Rule 3: batches are lines `[run_index, batch]` in one blob of gzip and base64, which the page unpacks itself.
"""

import base64
import zlib
from collections.abc import Iterable, Iterator, Sequence
from importlib.resources import files
from string import Template

SCRIPTS = (
    "map/outline.js",
    *(
        "run/columns.js",
        "run/body.js",
        "run/moments.js",
        "run/losses.js",
        "run/scenario.js",
        "run/run.js",
        "run/steps.js",
        "run/strand.js",
    ),
    *(
        "map/look.js",
        "map/view.js",
        "map/shapes.js",
        "map/ground.js",
        "map/layers.js",
        "map/sight.js",
        "map/robots.js",
        "map/hits.js",
        "map/legend.js",
        "map/pane.js",
    ),
    *(
        "panels/plots.js",
        "panels/scrub.js",
        "panels/tip.js",
        "panels/charts.js",
        "panels/chart_still.js",
        "panels/doings.js",
        "panels/lanes.js",
        "panels/cause.js",
        "panels/panels.js",
        "panels/nearness.js",
        "panels/inspector.js",
        "panels/tables.js",
        "panels/entries.js",
        "panels/differences.js",
    ),
    *("save/svg.js", "save/pictures.js", "span.js", "app.js", "player.js", "controls.js", "main.js"),
)
STYLES = ("styles/theme.css", "styles/page.css", "styles/words.css")

MARK = b"<title>Clew</title>"
"""Near the beginning of every page of ours."""

GZIP = 16 + zlib.MAX_WBITS  # zlib's request for a gzip header
EFFORT = 3  # of 9: level 6 saves a sixth of the size and takes three times as long


def document(
    runs: Sequence[Iterable[bytes]] = (), *, scripts: Sequence[str] = (), connects: bool = False
) -> str:
    """The page as one HTML file.

    Args:
        runs: the batches of each run, as `Batches.batch` gives them.
        scripts: JavaScript to run after the page is built; the page's hooks are in `window.clew`.
        connects: whether scripts may send requests to the page's origin.
    """
    assets = files("clew.page") / "assets"
    own = [(assets / name).read_text(encoding="utf-8") for name in SCRIPTS]
    return Template((assets / "index.html").read_text(encoding="utf-8")).substitute(
        policy=_policy(connects=connects),
        styles="\n".join((assets / name).read_text(encoding="utf-8") for name in STYLES),
        scripts="\n".join(own),
        more="".join(f"<script>\n{script}\n</script>\n" for script in scripts),
        story=blob(runs),
    )


def blob(runs: Sequence[Iterable[bytes]]) -> str:
    """Rule 3: the batches as text; empty without a run."""
    packer = zlib.compressobj(EFFORT, zlib.DEFLATED, GZIP)
    packed = b"".join(packer.compress(line) for line in _lines(runs)) + packer.flush()
    return base64.b64encode(packed).decode() if runs else ""


def _lines(runs: Sequence[Iterable[bytes]]) -> Iterator[bytes]:
    for index, batches in enumerate(runs):
        for batch in batches:
            yield b"[%d,%b]\n" % (index, batch)


def _policy(*, connects: bool) -> str:
    to = "'self'" if connects else "'none'"
    return f"default-src 'none'; script-src 'unsafe-inline'; style-src 'unsafe-inline'; connect-src {to}"
