"""Lines that are printed to be copied work in the folder in which they are printed."""

import shlex
from pathlib import Path

import pytest

from clew.verbs import say
from protocol.root import ROOT

LINE = "./launch/clew rehearse 'my scenes/one.json' --seed 1"


def test_a_line_to_copy_stays_as_it_is_in_the_projects_folder(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(ROOT)
    assert say.to_copy(LINE) == LINE


@pytest.mark.parametrize("program", ["./launch/clew", "./launch/fleet.sh"])
def test_a_line_to_copy_finds_the_program_from_another_folder(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, program: str
) -> None:
    monkeypatch.chdir(tmp_path)
    found, *rest = shlex.split(say.to_copy(f"{program} 'a b.toml' --seed 1"))
    assert (tmp_path / found).is_file()
    assert rest == ["a b.toml", "--seed", "1"]


@pytest.mark.parametrize(
    ("line", "installed"),
    [
        (LINE, "clew rehearse 'my scenes/one.json' --seed 1"),
        ("./launch/fleet.sh one.toml --seed 1", "clew run one.toml --seed 1"),
    ],
)
def test_a_line_to_copy_calls_the_installed_program_where_there_is_no_checkout(
    monkeypatch: pytest.MonkeyPatch, line: str, installed: str
) -> None:
    monkeypatch.setattr(say, "IS_CHECKOUT", False)
    assert say.to_copy(line) == installed
