"""Maps as ROS keeps them, for tests."""

from collections.abc import Sequence
from pathlib import Path

import numpy as np

FIELDS: dict[str, object] = {
    "image": "map.pgm",
    "resolution": 0.5,
    "origin": "[0.0, 0.0, 0.0]",
    "negate": 0,
    "occupied_thresh": 0.65,
    "free_thresh": 0.196,
}


def written(folder: Path, shades: Sequence[Sequence[int]] | np.ndarray, **fields: object) -> Path:
    """Write a map of these shades, the highest row first; fields replace the usual ones, or with None go."""
    rows = np.array(shades, dtype=np.uint8)
    (folder / "map.pgm").write_bytes(b"P5\n%d %d\n255\n" % rows.shape[::-1] + rows.tobytes())
    said = {name: value for name, value in (FIELDS | fields).items() if value is not None}
    path = folder / "map.yaml"
    path.write_text("".join(f"{name}: {value}\n" for name, value in said.items()), encoding="utf-8")
    return path
