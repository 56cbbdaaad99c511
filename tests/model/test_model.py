"""The short form of the model: clean with all rules, broken without each."""

from collections.abc import Iterable
from typing import get_args, get_type_hints

import pytest

from tests.model.properties import Property
from tests.model.register import may_win, takes_raise
from tests.model.rules import DESIGN, SCHEDULES, Rule
from tests.model.search import Ended, search
from tests.model.searches import BROKEN, LONG, NOT_SHOWN, SHORT, Clean, Without
from tests.model.setting import Bounds, Setting
from tests.model.state import Message
from tests.model.values import Epoch, Fence, May

CLEAN_ANYHOW = {entry.bounds for entry in SHORT}
PAIRS = [entry for entry in BROKEN if len(entry.rules) > 1]

# The dearest searches, a second and more each; of each family of rules, and of each setting, others are left.
DEAR_CLEAN = {"bodies brake", "the world restarts", "a stop around a lease", "three robots, a restart"}
DEAR_WITHOUT = {Rule.PLACE_OF_THIS_EPOCH, Rule.SCAN_OF_THIS_TURN, Rule.NEW_LIFE_STANDS, Rule.NEXT_TURN_ONLY}
DEAR_WITHOUT |= {Rule.LIFE_IN_TURN, Rule.PLACE_STANDING, Rule.TURN_0_SCAN_ONLY_FOR_TURN_1}
CLEAN = [entry for entry in SHORT if entry.name not in DEAR_CLEAN]
CLEAN_TOO = [entry for entry in SHORT if entry.name in DEAR_CLEAN]
WITHOUT = [entry for entry in BROKEN if not entry.rules & DEAR_WITHOUT]
WITHOUT_TOO = [entry for entry in BROKEN if entry.rules & DEAR_WITHOUT]


def name_of(entry: Clean | Without) -> str:
    if isinstance(entry, Clean):
        return entry.name
    return "+".join(sorted(rule.name for rule in entry.rules))


def dear(entries: Iterable[Clean | Without]) -> list[object]:
    """For `launch/test.sh --long` only. (`long` takes a tuple for several arguments.)"""
    return [pytest.param(entry, marks=pytest.mark.long) for entry in entries]


def differences(bounds: Bounds) -> str:
    usual = Bounds()._asdict()
    return (
        ",".join(f"{name}={value}" for name, value in bounds._asdict().items() if value != usual[name]) or "-"
    )


@pytest.mark.parametrize("entry", [*CLEAN, *dear(CLEAN_TOO)], ids=name_of)
def test_all_rules_together_are_clean_and_the_search_closes(entry: Clean) -> None:
    found = search(Setting(DESIGN, entry.bounds))
    assert (found.broken, found.ended, found.states) == (None, Ended.CLOSED, entry.states)


@pytest.mark.parametrize("entry", [*WITHOUT, *dear(WITHOUT_TOO)], ids=name_of)
def test_without_its_rules_a_property_breaks(entry: Without) -> None:
    found = search(Setting(DESIGN - entry.rules, entry.bounds, {entry.broken}))
    assert (found.broken, found.depth, len(found.trace)) == (entry.broken, entry.depth, entry.depth)


@pytest.mark.long
@pytest.mark.parametrize("entry", PAIRS, ids=name_of)
def test_rules_that_cover_each_other_break_only_together(entry: Without) -> None:
    for back in entry.rules:
        found = search(Setting(DESIGN - entry.rules | {back}, entry.bounds, {entry.broken}))
        assert (back, found.broken, found.ended) == (back, None, Ended.CLOSED)


@pytest.mark.parametrize("bounds", sorted({entry.bounds for entry in BROKEN} - CLEAN_ANYHOW), ids=differences)
def test_bounds_that_break_without_a_rule_are_clean_with_all(bounds: Bounds) -> None:
    found = search(Setting(DESIGN, bounds))
    assert (found.broken, found.ended) == (None, Ended.CLOSED)


def test_every_rule_is_shown_or_named_with_the_reason_why_not() -> None:
    shown = frozenset[Rule]().union(*(entry.rules for entry in BROKEN))
    assert shown | NOT_SHOWN.keys() == DESIGN
    assert not shown & NOT_SHOWN.keys()


def test_every_property_is_broken_by_some_rule_left_out() -> None:
    assert {entry.broken for entry in BROKEN} == set(Property)


def test_every_rule_has_a_family_of_the_design_and_its_own_sentence() -> None:
    assert {rule.family for rule in Rule} == {"F1", "F2", "F3", "F4", "F5", "F6", "REGISTER"}
    assert len(set(Rule)) == len(Rule.__members__)
    assert SCHEDULES.keys() <= DESIGN


def test_searches_have_names_of_their_own() -> None:
    assert len({entry.name for entry in (*SHORT, *LONG)}) == len((*SHORT, *LONG))


def test_no_two_kinds_of_message_can_be_equal() -> None:
    shapes = [str(list(get_type_hints(kind).values())).replace("bool", "int") for kind in get_args(Message)]
    assert len(set(shapes)) == len(shapes)


def test_breaches_of_properties_that_are_not_asked_for_pass() -> None:
    entry = next(entry for entry in BROKEN if entry.rules == {Rule.ONE_NAMED})
    found = search(Setting(DESIGN - entry.rules, entry.bounds, {Property.STOP_HOLDS}))
    assert (found.broken, found.ended) == (None, Ended.CLOSED)


def test_a_search_that_runs_out_of_depth_says_so() -> None:
    found = search(Setting(DESIGN, Bounds(depth=3)))
    assert (found.broken, found.depth, found.ended) == (None, 3, Ended.DEPTH)


def test_a_raise_over_stopped_is_refused_but_kept_for_after_the_release() -> None:
    setting, stopped = Setting(DESIGN, Bounds()), Fence(Epoch(4, -1, 0), 0, May.STOPPED)
    assert may_win(setting, Epoch(5, 0, 0), stopped)
    assert not takes_raise(setting, Epoch(5, 0, 0), stopped)
