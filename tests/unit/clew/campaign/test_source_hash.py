"""Which source decides an episode: after a change of it, the episode is played again."""

import subprocess
import sys
from pathlib import Path

from clew.campaign.campaign import PLAYED
from protocol.root import ROOT

LOADED = """
import sys
from pathlib import Path
from msgspec.structs import replace
from clew.campaign.campaign import drawn_episode
from clew.campaign.episode import play
drawn = drawn_episode(3, Path(), "", wall_s_max=100.0)
play(replace(drawn, judged=True, branches="", guided=True))
files = [getattr(module, "__file__", None) for module in sys.modules.values()]
print(*filter(None, files), sep="\\n")
"""


def test_all_source_that_plays_an_episode_counts_in_its_hash() -> None:
    """Else an episode would count as played after a change that would let it end otherwise."""
    loaded = subprocess.run([sys.executable, "-c", LOADED], capture_output=True, text=True, check=True).stdout
    ours = [
        path.relative_to(ROOT) for path in map(Path, loaded.split()) if path.is_relative_to(ROOT / "clew")
    ]
    assert [path for path in ours if not any(path.is_relative_to(each) for each in PLAYED)] == [
        Path("clew/__init__.py")
    ]
