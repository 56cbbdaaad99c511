"""Has the second judge look at a run, and makes small runs for it. Not a test file."""

import json
from pathlib import Path
from typing import Any

from clew.judge.agree import disagreements
from clew.judge.poses import Finding, judge
from clew.judge.truth import read

Row = tuple[float, float, float]


def differences(run: Path) -> list[str]:
    """In what true poses contradict the verdict of a run; nothing where a test has taken one of them away."""
    verdict = run / "verdict.json"
    if not verdict.exists() or not (run / "events.jsonl").exists():
        return []
    return list(disagreements(found_in(run), json.loads(verdict.read_text())))


def found_in(run: Path) -> Finding:
    """What the second judge finds in a folder."""
    with (run / "events.jsonl").open("rb") as lines:
        return judge(read(lines))


def scenario(**changes: Any) -> dict[str, Any]:  # noqa: ANN401 - sections have any content
    """Robots of 0.1 m that keep 0.08 m from obstacles and 0.03 m from each other; the goal is at (4, 0)."""
    return {
        "fleet": {"robot_radius_m": 0.1, "separation_m": 0.05, "link_length_m_max": 1.0},
        "law": {"law": "certified", "epsilon_m": 0.1, "mu0_m": 0.02},
        "drive": {"speed_mps_max": 1.0},
        "goal": {"at_m": [4.0, 0.0], "tolerance_m": 0.1},
        "bounds": {"x_m_min": -9.0, "y_m_min": -9.0, "x_m_max": 9.0, "y_m_max": 9.0},
    } | changes


def poses(robot: int, *rows: Row, source: str = "world") -> list[dict[str, Any]]:
    """Entries of a body: t, x, y."""
    return [
        {"kind": "pose.sampled", "source": source, "robot": robot, "t_s": t_s, "x_m": x_m, "y_m": y_m}
        for t_s, x_m, y_m in rows
    ]


def written(entries: list[dict[str, Any]], said: dict[str, Any], faults: object = None) -> list[bytes]:
    """The lines of a run's file."""
    header = {"kind": "run.started", "source": "world", "t_s": 0.0, "scenario": said, "faults": faults}
    return [json.dumps(each, separators=(",", ":")).encode() + b"\n" for each in (header, *entries)]


def found(entries: list[dict[str, Any]], said: dict[str, Any] | None = None) -> Finding:
    """What the second judge finds in these entries."""
    return judge(read(written(entries, said or scenario())))
