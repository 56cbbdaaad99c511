"""Where this program is: the folder of the packages, which in a checkout also holds `launch/` and `docs/`."""

from pathlib import Path

ROOT = Path(__file__).parent.parent

_INSTALLED = Path(__file__).parent / "launch"
"""Where a wheel puts scenarios and fault plans: `launch` itself is a package of ROS 2."""

IS_CHECKOUT = not _INSTALLED.is_dir()

LAUNCH = ROOT / "launch" if IS_CHECKOUT else _INSTALLED
"""The folder with `scenarios/` and `faults/`."""
