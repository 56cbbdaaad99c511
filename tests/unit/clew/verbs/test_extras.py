"""The command line that installs a missing extra."""

import importlib.util
import shlex
import sys

import pytest

from clew.verbs import extras
from protocol.root import ROOT


def test_the_line_installs_an_extra_into_the_running_environment(monkeypatch: pytest.MonkeyPatch) -> None:
    words = shlex.split(extras.install_line("plot"))
    assert words[-1] == f"{ROOT}[plot]"
    assert (ROOT / "pyproject.toml").exists()
    assert sys.executable in words
    monkeypatch.setattr(extras, "find_spec", lambda _: None)
    assert shlex.split(extras.install_line("plot"))[:4] == ["uv", "pip", "install", "--python"]


def test_the_line_uses_pip_exactly_if_pip_is_installed() -> None:
    said = extras.install_line("plot")
    assert ("-m pip" in said) == (importlib.util.find_spec("pip") is not None)
