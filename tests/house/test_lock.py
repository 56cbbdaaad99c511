"""The lock file: it pins everything in pyproject.toml by hash and names no package index."""

import json
import re
import subprocess
import sys
import tomllib
from collections import defaultdict
from collections.abc import Iterator
from functools import cache
from importlib.metadata import PackageNotFoundError, requires
from itertools import chain
from typing import Any

import pytest
from packaging.requirements import InvalidRequirement, Requirement
from packaging.utils import canonicalize_name

from protocol.root import ROOT
from tests.support.deadline import DEADLINE_S

DESCRIBED = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))
LOCK = (ROOT / "requirements.lock").read_text(encoding="utf-8")
EXTRAS = DESCRIBED["project"]["optional-dependencies"]
PYTHONS = ("3.11", "3.12", "3.13", "3.14")
HASH = re.compile(r"sha256:[0-9a-f]{64}")


def asked_for(described: dict[str, Any]) -> Iterator[Requirement]:
    """All requirements in pyproject.toml, except our own extras."""
    project = described["project"]
    groups = (*project["optional-dependencies"].values(), *described["dependency-groups"].values())
    lists = chain(project["dependencies"], described["build-system"]["requires"], *groups)
    for requirement in map(Requirement, lists):
        if requirement.name != project["name"]:
            yield requirement


def complaints(described: dict[str, Any], lock: str) -> Iterator[str]:
    """The reasons why a lock file is unsafe or does not match this project."""
    if "://" in lock:
        yield "it names a place"
    pins = defaultdict[str, list[Requirement]](list)
    for line in lock.replace("\\\n", "").splitlines():
        pin, *hashes = line.partition("#")[0].split("--hash=")
        if not pin.strip():
            continue
        if not hashes or not all(HASH.fullmatch(each.strip()) for each in hashes):
            yield f"{pin.strip()}: has no hash"
        try:
            requirement = Requirement(pin)
        except InvalidRequirement:
            yield f"{pin.strip()}: is no pin"
        else:
            pins[canonicalize_name(requirement.name)].append(requirement)
    for requirement in asked_for(described):
        for python in PYTHONS:
            yield from step_complaints(requirement, pins[canonicalize_name(requirement.name)], python)


def step_complaints(asked: Requirement, pins: list[Requirement], python: str) -> Iterator[str]:
    there = {"python_version": python, "python_full_version": f"{python}.0"}
    used = [pin for pin in pins if pin.marker is None or pin.marker.evaluate(there)]
    if len(used) != 1:
        yield f"{asked}: has {len(used)} pins for Python {python}"
    for pin in used:
        (specifier,) = pin.specifier
        if specifier.operator != "==" or not asked.specifier.contains(specifier.version):
            yield f"{asked}: is pinned as {pin}"


def test_the_lock_holds_everything_the_project_requires() -> None:
    assert not list(complaints(DESCRIBED, LOCK))


@pytest.mark.parametrize(
    ("pattern", "becomes", "complaint"),
    [
        (r"^h11==.*\n( .*\n)+", "", "h11~=0.16.0: has 0 pins for Python 3.11"),
        (r"^h11==.*? ", "h11==0.14.0 ", "h11~=0.16.0: is pinned as h11==0.14.0"),
        (r"^h11==.*? ", "h11>=0.16.0 ", "h11~=0.16.0: is pinned as h11>=0.16.0"),
        (r"^(h11==\S*).*\n( +--hash.*\n)+", r"\1\n", "h11==0.16.0: has no hash"),
        (r"\A", "--index-url internal\n", "--index-url internal: is no pin"),
        (r"\A", "# --find-links file://wheels\n", "it names a place"),
    ],
)
def test_a_lock_that_does_not_match_is_found(pattern: str, becomes: str, complaint: str) -> None:
    broken, count = re.subn(pattern, becomes, LOCK, count=1, flags=re.MULTILINE)
    assert count == 1
    assert complaint in complaints(DESCRIBED, broken)


@pytest.mark.parametrize(
    ("listed", "complaint"),
    [
        ("h11~=0.17.0", "h11~=0.17.0: is pinned as h11==0.16.0"),
        ("flask", "flask: has 0 pins for Python 3.14"),
    ],
)
def test_a_project_with_other_requirements_is_found(listed: str, complaint: str) -> None:
    extras = {**EXTRAS, "dev": [*EXTRAS["dev"], listed]}
    project = {**DESCRIBED["project"], "optional-dependencies": extras}
    assert complaint in complaints({**DESCRIBED, "project": project}, LOCK)


@cache
def needed(*extra: str) -> frozenset[str]:
    """The names that the set-up installs for an extra, or for a run."""
    command = [sys.executable, "-IS", str(ROOT / "launch" / "locked.py"), *extra]
    printed = subprocess.run(command, capture_output=True, text=True, timeout=DEADLINE_S, check=True).stdout
    return frozenset(re.findall(r"^([a-z0-9-]+)==", printed, flags=re.MULTILINE))


def test_a_run_downloads_no_library_for_figures_or_tests() -> None:
    assert {"numpy", "eclipse-zenoh", "hatchling"} <= needed()
    assert not {"matplotlib", "pyarrow", "playwright", "mypy"} & needed()
    assert "rerun-sdk" not in needed("dev")


def test_an_extra_includes_everything_that_its_packages_require() -> None:
    missing = {
        f"{name} requires {dependency.name}, which {extra or 'a run'} does not include"
        for extra in ("", *EXTRAS)
        for name in needed(*filter(None, [extra]))
        for dependency in dependencies(name)
        if canonicalize_name(dependency.name) not in needed(*filter(None, [extra]))
    }
    assert not missing


def dependencies(name: str) -> Iterator[Requirement]:
    """The requirements of an installed package on this platform."""
    try:
        listed = requires(name) or []
    except PackageNotFoundError:  # of another platform, or rerun, which is optional
        return
    for dependency in map(Requirement, listed):
        if dependency.marker is None or dependency.marker.evaluate({"extra": ""}):
            yield dependency


def test_every_locked_package_is_needed_by_an_extra() -> None:
    assert set(re.findall(r"^([a-z0-9-]+)==", LOCK, flags=re.MULTILINE)) == set().union(*map(needed, EXTRAS))


def test_the_lock_of_the_page_types_has_hashes_and_names_no_registry() -> None:
    text = (ROOT / "tests" / "support" / "page_types" / "package-lock.json").read_text(encoding="utf-8")
    assert "://" not in text, (
        "write it with: npm install --package-lock-only --omit-lockfile-registry-resolved"
    )
    packages = json.loads(text)["packages"]
    assert packages.pop("")["devDependencies"] == {
        name.removeprefix("node_modules/"): package["version"] for name, package in packages.items()
    }
    assert all(package["integrity"].startswith("sha512-") for package in packages.values())
