"""Small scenes for the tests of rehearsals and campaigns. A rehearsal in one takes 0.1 s of wall time."""

import json
from pathlib import Path
from typing import Any

import msgspec
from click.testing import CliRunner, Result

from clew.campaign.episode import Outcome, Surprise
from clew.cli import main

WALL = [[2.7, -1.0], [3.2, -1.0], [3.2, 1.0], [2.7, 1.0]]


def scene(path: Path, **changes: object) -> Path:
    """Write a corridor of 6 m by 2 m with a post beside the way; `keys` replace its values."""
    said: dict[str, object] = {
        "schema": "clew-scene/1",
        "name": path.stem,
        "units": "m",
        "robot_radius": 0.1,
        "start": [2.0, 0.0, 0.0],
        "goal": [4.0, 0.0],
        "goal_tol": 0.2,
        "bounds": [0.0, -1.0, 6.0, 1.0],
        "circles": [[3.0, 0.6, 0.2]],
        "polygons": [],
        "stats": {"widest_path_radius": 0.7},
    }
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_text(json.dumps(said | changes), encoding="utf-8")
    return path


def closed(path: Path, **changes: object) -> Path:
    """The same with a wall across: there is no way."""
    across: dict[str, object] = {"polygons": [WALL], "stats": {"widest_path_radius": 0.0}}
    return scene(path, **(across | changes))


def refused(path: Path) -> Path:
    """The same with an obstacle where the robots start: the loader refuses such a scene."""
    return scene(path, circles=[[2.0, 0.0, 0.3]])


def clew(*arguments: str | Path) -> Result:
    return CliRunner().invoke(main, [str(argument) for argument in arguments])


def told(out: Path) -> dict[str, Any]:
    """What a campaign says of itself."""
    read: dict[str, Any] = json.loads((out / "campaign.json").read_text(encoding="utf-8"))
    return read


def outcome(**changes: object) -> Outcome:
    ended = Outcome(
        key="",
        scene="a",
        family="f",
        seed=1,
        robots=5,
        robots_left_out=0,
        ok=True,
        ending="",
        reason="",
        surprise=Surprise.NONE,
        wall_s=1.0,
        replay="",
    )
    return msgspec.structs.replace(ended, **changes)
