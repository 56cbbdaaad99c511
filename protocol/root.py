"""The root of this program: the folder that contains `launch/`, `docs/` and the packages."""

from pathlib import Path

ROOT = Path(__file__).parent.parent
