"""The words of the command line: one spelling everywhere, and mistyped ones refused in a line."""

import math
import re
from collections.abc import Callable

import click
import pytest

from clew.cli import main
from clew.fleet.options import version
from clew.verbs.options import Finite
from tests.support.campaigns import clew
from tests.support.verbs import asked, commands

MISTYPED = {
    "a verb": (["rehears"], "'rehearse'"),
    "a verb of a verb": (["log", "chek", "run"], "'check'"),
    "a fault": (["fault", "run", "kil", "3"], "'kill'"),
    "an option": (["rehearse", "--sed", "1"], "'--seed'"),
    "a law": (["rehearse", "--law", "certifid"], "'certified'"),
    "a scenario": (["rehearse", "papper"], "'paper'"),
    "a fault plan": (["rehearse", "--faults", "bursst"], "'burst'"),
    "a target": (["fault", "run", "kill", "ledder"], "'leader'"),
    "a message's kind": (["fault", "run", "drop", "--kind", "ahed"], "'ahead'"),
    "a schema": (["schema", "fault"], "'faults'"),
    "an export": (["log", "export", "run", "--to", "mcp"], "'mcap'"),
}
REFUSED = [
    ["--nothing"],
    ["rehearse", "--seed", "x"],
    ["campaign", "--robots", "0"],
    ["log", "check"],
    ["log", "cat", "run", "--step", "x"],
    ["view"],
    ["log", "cat", "run", "--from", "nan"],
    ["log", "messages", "run", "--to", "inf"],
    ["replay", "run", "--until", "nan"],
    ["field", "--seed", "1"],
]
# An empty text is what an unset variable of a shell gives.
EMPTY = [
    ["run", "--speed", ""],
    ["campaign", "grove", "--seeds", ""],
    ["log", "cat", "run", "--robot", ""],
    ["log", "messages", "run", "--link", ""],
    ["log", "messages", "run", "--step", ""],
    ["fault", "run", "kill", ""],
    ["fault", "run", "freeze", "3", "--for", ""],
    ["mutants", "--mutant", ""],
]
# What an option would be given for nothing is said.
NO_USE = {
    "the setting of a rule": (["explore", "turns", "--without", "F3"], "--without: explores the setting"),
    "the bounds of a rule": (
        ["explore", "--without", "F3", "--skip", "3"],
        "--without: explores the setting",
    ),
    "no way for all": (["explore", "round", "--recovers"], "--recovers: is for settings with a way"),
    "nothing drawn": (["campaign", "anywhere", "--keep"], "--keep: need --faults swarm"),
    "no seed": (
        ["mutants", "--guided", "--mutant", "puts-untold"],
        "--mutant puts-untold: a test catches it",
    ),
    "no such kind": (["log", "cat", "run", "--without", "pose.sample"], "there is no kind 'pose.sample'"),
}


VERBS = {path: verb for path, verb in commands(main) if path}


def test_no_verb_takes_a_number_that_is_infinite_or_none() -> None:
    refused = dict[str, str]()
    for path, verb in VERBS.items():
        for param in verb.params:
            if isinstance(param.type, click.types.FloatParamType | click.FloatRange | Finite):
                convert: Callable[..., object] = param.type.convert
                with pytest.raises(click.BadParameter) as refusal:
                    convert(math.nan, None, None)
                refused[f"{path} {param.name}"] = str(refusal.value)
    assert len(refused) > 10
    assert {said for said in refused.values() if "finite number" not in said} == set()


def test_no_verb_takes_an_empty_text_for_a_path() -> None:
    refused = dict[str, str]()
    for path, verb in VERBS.items():
        for param in verb.params:
            if isinstance(param.type, click.Path):
                with pytest.raises(click.BadParameter) as refusal:
                    param.type.convert("", None, None)
                refused[f"{path} {param.name}"] = str(refusal.value)
    assert len(refused) > 20
    assert {said for said in refused.values() if said != "must be a path, got an empty text"} == set()
    assert clew("rehearse", "--out", "").stderr.startswith("Error: Invalid value for '--out': must be a path")


@pytest.mark.parametrize(("arguments", "near"), MISTYPED.values(), ids=MISTYPED)
def test_a_mistyped_word_is_refused_in_one_line_that_says_which_is_near(
    arguments: list[str], near: str
) -> None:
    said = clew(*arguments)
    assert (said.exit_code, said.stdout, said.stderr.count("\n")) == (2, "", 1)
    assert re.search(f"[Dd]id you mean {near}", said.stderr)
    assert ".;" not in said.stderr


@pytest.mark.parametrize(
    ("option", "value", "kind"),
    [("-n", "abc", "an integer"), ("--seed", "1.5", "an integer"), ("--time-s-max", "long", "a number")],
)
def test_a_word_in_the_place_of_a_number_is_refused_by_the_kind_of_number(
    option: str, value: str, kind: str
) -> None:
    said = clew("rehearse", option, value)
    assert said.exit_code == 2
    assert f"'{value}' is not {kind}. (" in said.stderr


@pytest.mark.parametrize("arguments", REFUSED, ids=" ".join)
def test_what_cannot_be_done_is_one_line(arguments: list[str]) -> None:
    said = clew(*arguments)
    assert (said.exit_code, said.stdout, said.stderr.count("\n")) == (2, "", 1)
    assert said.stderr.startswith("Error: ")
    assert "\\" not in said.stderr


@pytest.mark.parametrize("arguments", EMPTY, ids=" ".join)
def test_an_empty_text_that_is_refused_is_shown(arguments: list[str]) -> None:
    said = clew(*arguments)
    assert (said.exit_code, said.stdout, said.stderr.count("\n")) == (2, "", 1)
    assert "got ''" in said.stderr


@pytest.mark.parametrize(("arguments", "why"), NO_USE.values(), ids=NO_USE)
def test_an_option_that_would_do_nothing_is_refused(arguments: list[str], why: str) -> None:
    said = clew(*arguments)
    assert (said.exit_code, said.stdout, said.stderr.count("\n")) == (2, "", 1)
    assert why in said.stderr


@pytest.mark.parametrize("verb", VERBS, ids=" ".join)
def test_every_verb_gives_help_for_either_spelling(verb: tuple[str, ...]) -> None:
    arguments = ["fault", "run", *verb[1:]] if verb[0] == "fault" and len(verb) > 1 else list(verb)
    short, long = clew(*arguments, "-h"), clew(*arguments, "--help")
    assert (short.exit_code, short.stderr) == (0, "")
    assert short.stdout == long.stdout
    assert short.stdout.startswith("Usage: ")


def test_a_group_without_a_verb_gives_its_help() -> None:
    assert "Commands:" in clew("log").output


def test_the_number_of_robots_is_spelt_in_one_way() -> None:
    spellings = {
        verb: each.opts
        for verb, command in VERBS.items()
        for each in command.params
        if isinstance(each, click.Option) and each.name == "robots"
    }
    assert {("rehearse",), ("campaign",), ("fault", "kill")} <= set(spellings)
    assert {tuple(opts) for opts in spellings.values()} == {("-n", "--robots")}
    assert asked("grove", "-n", "3") == asked("grove", "--robots", "3")


def test_the_version_is_told() -> None:
    assert clew("--version").stdout == f"{version()}\n"
    assert clew("run", "--version").stdout == f"{version()}\n"


@pytest.mark.parametrize("verb", ["campaign", "field"])
def test_more_seeds_than_fit_into_memory_are_refused_in_one_line(verb: str) -> None:
    said = clew(verb, "circles", "--seeds", "1-9999999999999")
    assert (said.exit_code, said.stderr.count("\n")) == (2, 1)
    assert "must be at most 1,000,000 seeds" in said.stderr
