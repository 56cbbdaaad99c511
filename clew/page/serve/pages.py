"""The contents of the viewer's site: the page and its feeds."""

import base64
import hashlib
import json
import re
from importlib.resources import files

from clew.page.document import document
from clew.page.serve.site import Document, Site

SCRIPT = re.compile(r"<script>(.*?)</script>", re.DOTALL)


def site(runs: int) -> Site:
    """The page for this many runs, and a feed for each of them."""
    feeds = [f"/events/{run}" for run in range(runs)]
    live = (files("clew.page.serve") / "live.js").read_text(encoding="utf-8")
    page = document(scripts=[f"const FEEDS = {json.dumps(feeds)};\n{live}"], connects=True)
    return {
        "/": Document(page.encode(), policy=policy(page)),
        **{feed: run for run, feed in enumerate(feeds)},
    }


def policy(page: str) -> str:
    """A Content-Security-Policy that allows only the page's own scripts.

    So no content of a log can ever run there, and no other page can hold ours in a frame.
    """
    scripts = " ".join(f"'sha256-{_digest(script)}'" for script in SCRIPT.findall(page))
    return (
        f"default-src 'none'; script-src {scripts}; style-src 'unsafe-inline'; connect-src 'self'; "
        "base-uri 'none'; form-action 'none'; frame-ancestors 'none'"
    )


def _digest(script: str) -> str:
    return base64.b64encode(hashlib.sha256(script.encode()).digest()).decode()
