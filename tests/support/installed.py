"""Packages with laws, as an installer leaves them in a folder. Not a test file."""

from collections.abc import Mapping
from pathlib import Path


def install(folder: Path, package: str, laws: Mapping[str, str]) -> None:
    """Leave the record of a package there that brings these laws, by name; its code is somebody else's."""
    record = folder / f"{package}-1.0.dist-info"
    record.mkdir(parents=True)
    (record / "METADATA").write_text(f"Metadata-Version: 2.1\nName: {package}\nVersion: 1.0\n")
    lines = [f"{name} = {value}" for name, value in laws.items()]
    (record / "entry_points.txt").write_text("\n".join(["[clew.laws]", *lines, ""]))
