"""Whoever lacks an extra is told a line that brings it to where it lacks."""

import importlib.util
import shlex
import sys

import pytest

from clew.verbs import extras
from protocol.root import ROOT


def test_an_extra_comes_into_the_environment_that_runs(monkeypatch: pytest.MonkeyPatch) -> None:
    words = shlex.split(extras.install_line("plot"))
    assert words[-1] == f"{ROOT}[plot]"
    assert (ROOT / "pyproject.toml").exists()
    assert sys.executable in words
    monkeypatch.setattr(extras, "find_spec", lambda _: None)
    assert shlex.split(extras.install_line("plot"))[:4] == ["uv", "pip", "install", "--python"]


def test_pip_is_there_where_the_line_says_pip() -> None:
    said = extras.install_line("plot")
    assert ("-m pip" in said) == (importlib.util.find_spec("pip") is not None)
