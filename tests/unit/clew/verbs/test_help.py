"""The help of the command line: every verb has its place, and every option says what it does."""

from collections.abc import Iterator

import click
import pytest

from clew.cli import SECTIONS, main
from tests.support.campaigns import clew

Path = tuple[str, ...]


def commands(command: click.Command, path: Path = ()) -> Iterator[tuple[Path, click.Command]]:
    yield path, command
    if isinstance(command, click.Group):
        for name, each in command.commands.items():
            yield from commands(each, (*path, name))


ALL = dict(commands(main))


def test_the_proving_ground_stands_apart_from_the_verbs_for_a_run() -> None:
    text = clew("--help").stdout
    run, proving = text.split("A run:")[1].split("Proving ground")
    for verb in ("rehearse", "fault", "view", "report", "log", "replay", "figures", "schema"):
        assert f"\n  {verb} " in run
    for verb in ("campaign", "chaos", "shrink", "mutants", "bench", "field"):
        assert f"\n  {verb} " in proving


def test_every_verb_stands_in_one_section() -> None:
    named = [verb.name for verbs in SECTIONS.values() for verb in verbs]
    assert sorted(map(str, named)) == sorted(main.commands)


@pytest.mark.parametrize("path", ALL, ids=" ".join)
def test_a_verb_says_what_it_does_and_so_does_each_of_its_options(path: Path) -> None:
    command = ALL[path]
    assert command.help
    assert command.help.split(".")[0].count("\n") == 0, "the first sentence is one line"
    options = [each for each in command.params if isinstance(each, click.Option) and not each.hidden]
    assert [each.name for each in options if not each.help] == []
