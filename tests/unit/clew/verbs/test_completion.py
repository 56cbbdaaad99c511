"""Completion in the shell is quick: it imports none of what verbs work with."""

import json
import os
import subprocess
import sys

import pytest
from click.shell_completion import BashComplete, get_completion_class

from clew.cli import main
from protocol.root import ROOT
from tests.support.deadline import DEADLINE_S
from tests.support.verbs import commands

HEAVY = {"asyncio", "matplotlib", "numpy", "rich", "scipy", "shapely", "zenoh"}
MODULES_MAX = 330  # click, msgspec and some of ours; numpy and scipy alone are 400
CHECK = """
import json, os, sys
from click.shell_completion import BashComplete
from clew.cli import main
for path in json.loads(sys.argv[1]):
    read, write = os.pipe()
    if os.fork() == 0:
        words = [path[0], "runs/latest", *path[1:]] if path[:1] == ["fault"] and path[1:] else path
        found = BashComplete(main, {}, "clew", "_CLEW_COMPLETE").get_completions(words, "--")
        options = [each.value for each in found]
        print(json.dumps([path, options, sorted(sys.modules)]), flush=True)
        os._exit(0)
    os.wait()
"""


@pytest.fixture(scope="module")
def completed() -> dict[str, tuple[list[str], set[str]]]:
    """The options and the imported modules when the options of each verb are completed."""
    paths = json.dumps([path for path, _ in commands(main)])
    ended = subprocess.run(
        [sys.executable, "-c", CHECK, paths],
        cwd=ROOT,
        env={**os.environ, "PYTHONPATH": str(ROOT)},
        capture_output=True,
        timeout=DEADLINE_S,
        check=True,
    )
    lines = map(json.loads, ended.stdout.decode().splitlines())
    return {" ".join(path): (options, set(modules)) for path, options, modules in lines}


@pytest.mark.parametrize("path", [" ".join(path) for path, _ in commands(main)])
def test_completion_imports_nothing_slow(path: str, completed: dict[str, tuple[list[str], set[str]]]) -> None:
    options, modules = completed[path]
    assert "--help" in options
    assert sorted(HEAVY & modules) == []
    assert len(modules) < MODULES_MAX


@pytest.mark.parametrize(
    ("words", "begun", "expected"),
    [
        ("", "re", ["rehearse", "replay", "report"]),
        ("log", "c", ["cat", "check"]),
        ("run", "gro", ["grove"]),
        ("run --faults", "leader-k", ["leader-killed"]),
        ("bench", "l", ["loss"]),
    ],
)
def test_verbs_scenarios_and_plans_are_completed(words: str, begun: str, expected: list[str]) -> None:
    shell = BashComplete(main, {}, "clew", "_CLEW_COMPLETE")
    assert [each.value for each in shell.get_completions(words.split(), begun)] == expected


@pytest.mark.parametrize("shell", ["bash", "zsh", "fish"])
def test_each_shell_gets_its_script(shell: str) -> None:
    kind = get_completion_class(shell)
    assert kind is not None
    assert "_CLEW_COMPLETE" in kind(main, {}, "clew", "_CLEW_COMPLETE").source()
