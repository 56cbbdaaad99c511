"""Prints the pins of requirements.lock that an extra needs, with their hashes: `launch/locked.py [EXTRA]`.

pip and uv install a lock as a whole, but a run needs a third of ours. The walk starts at the names in
pyproject.toml and follows the lock's own notes on what asks for what (`# via`). It ignores markers, which
stay with the pins, so it may take too much. If it took too little, the installer would stop: with
--require-hashes it refuses a package that has no pin.
"""

import re
import sys
import tomllib
from pathlib import Path

ROOT = Path(__file__).parents[1]

ASKED = re.compile(r"(?P<name>[\w.-]+)(?:\[(?P<extras>[^\]]+)\])?")
PIN = re.compile(r"^(?P<name>[a-z0-9-]+)==.*\n(?:[ \t]+.*\n)+", re.MULTILINE)
VIA = re.compile(r"^ +#(?: via)? +(?P<name>[a-z0-9-]+)$", re.MULTILINE)


def asked_for(requirements: list[str], extras: dict[str, list[str]], ours: str) -> set[str]:
    """The names of these requirements; of an extra of our own, the names that it stands for."""
    names = set[str]()
    for requirement in requirements:
        asked = ASKED.match(requirement)
        assert asked, requirement
        if asked["name"] == ours:
            for extra in asked["extras"].split(","):
                names |= asked_for(extras[extra.strip()], extras, ours)
        else:
            names.add(re.sub(r"[-_.]+", "-", asked["name"]).lower())
    return names


def pins_of(lock: str, names: set[str]) -> str:
    """The pins of these names and of all that they ask for."""
    pins = list(PIN.finditer(lock))
    needed, reached = set[str](), names
    while reached - needed:
        needed |= reached
        reached = {pin["name"] for pin in pins if needed & set(VIA.findall(pin[0]))}
    return "".join(pin[0] for pin in pins if pin["name"] in needed)


def main(extra: str | None = None) -> None:
    """Print what a run needs, and what an extra adds to it."""
    described = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))
    project = described["project"]
    extras = project["optional-dependencies"]
    requirements = described["dependency-groups"]["build"] + project["dependencies"]
    if extra is not None:
        requirements += extras[extra]
    lock = (ROOT / "requirements.lock").read_text(encoding="utf-8")
    sys.stdout.write(pins_of(lock, asked_for(requirements, extras, project["name"])))


if __name__ == "__main__":
    main(*sys.argv[1:])
