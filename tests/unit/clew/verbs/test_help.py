"""The help of the command line: every verb has its place, and every option says what it does."""

import shlex
from itertools import takewhile

import click
import pytest

from clew.cli import SECTIONS, main
from clew.verbs.examples import EXAMPLES
from tests.support.campaigns import clew
from tests.support.verbs import commands, context
from world.scenario.fleets import has_several, load_fleets
from world.scenario.scenario import load

Path = tuple[str, ...]


ALL = dict(commands(main))


def test_verbs_for_many_runs_have_a_section_of_their_own() -> None:
    text = clew("--help").stdout
    run, many = text.split("A run:")[1].split("Many runs")
    for verb in ("run", "rehearse", "ls", "fault", "view", "report", "log", "replay", "figures", "schema"):
        assert f"\n  {verb} " in run
    for verb in ("campaign", "chaos", "shrink", "mutants", "bench", "field"):
        assert f"\n  {verb} " in many


def test_every_verb_stands_in_one_section() -> None:
    named = [name for verbs in SECTIONS.values() for name in verbs]
    assert sorted(named) == main.list_commands(context(main))


@pytest.mark.parametrize("path", ALL, ids=" ".join)
def test_a_verb_says_what_it_does_and_so_does_each_of_its_options(path: Path) -> None:
    command = ALL[path]
    assert command.help
    assert command.help.split(".")[0].count("\n") == 0, "the first sentence is one line"
    options = [each for each in command.params if isinstance(each, click.Option) and not each.hidden]
    assert [each.name for each in options if not each.help] == []


@pytest.mark.parametrize("path", ALL, ids=" ".join)
def test_the_help_of_every_verb_ends_with_examples_of_it(path: Path) -> None:
    lines = EXAMPLES[" ".join(path)]
    assert lines
    assert all(line.split()[: len(path)] == list(path) for line in lines if path[:1] != ("fault",))
    text, ending = ALL[path].get_help(context(ALL[path])).split("Examples:\n")
    assert "Example:" not in text, "an example stands in the table alone"
    assert [line.strip() for line in ending.splitlines()] == [f"clew {line}" for line in lines]


def test_no_example_is_of_a_verb_that_is_not_there() -> None:
    assert sorted(EXAMPLES) == sorted(" ".join(path) for path in ALL)


@pytest.mark.parametrize("line", sorted({line for lines in EXAMPLES.values() for line in lines}))
def test_every_example_parses(line: str) -> None:
    above, words = context(main), list(takewhile(lambda word: word != ">", shlex.split(line)))
    verb: click.Command = main
    while isinstance(verb, click.Group):
        above = verb.make_context("clew", words, parent=above)
        rest = [*above._protected_args, *above.args]
        _, below, words = verb.resolve_command(above, rest)
        assert below is not None
        verb = below
    verb.make_context(str(verb.name), words, parent=above)


@pytest.mark.parametrize(
    "example",
    [each for verb in ("run", "rehearse") for each in EXAMPLES[verb] if "my." not in each],
)
def test_the_fleet_of_an_example_fits_its_scenario(example: str) -> None:
    verb, *words = shlex.split(example)
    options = ALL[(verb,)].make_context(verb, words).params
    if has_several(options["scenario"]):
        load_fleets(options["scenario"], robots=options["robots"], law=options["law"])
    else:
        load(options["scenario"], robots=options["robots"], law=options["law"], seed=options["seed"])
