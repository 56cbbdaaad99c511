"""Where this program stands: the folder that holds `launch/`, `docs/` and the packages."""

from pathlib import Path

ROOT = Path(__file__).parent.parent
