"""The four states: every pair of a state and a happening."""

import itertools

import pytest

from agents.membership.states import TRANSITIONS, Happening, State, after

CHANGES = {
    (State.BOUND, Happening.NEWER_EPOCH): State.BOUND,
    (State.JOINING, Happening.NEWER_EPOCH): State.BOUND,
    (State.MEMBER, Happening.NEWER_EPOCH): State.BOUND,
    (State.ASIDE, Happening.NEWER_EPOCH): State.BOUND,
    (State.BOUND, Happening.NAMED): State.JOINING,
    (State.JOINING, Happening.NEWER_FENCE): State.BOUND,
    (State.BOUND, Happening.FORMED): State.MEMBER,
    (State.BOUND, Happening.LEFT_OUT): State.ASIDE,
}
"""From the design, not from the code."""


@pytest.mark.parametrize(("state", "happening"), list(itertools.product(State, Happening)))
def test_every_pair_goes_where_the_design_says_or_changes_nothing(state: State, happening: Happening) -> None:
    assert after(state, happening) is CHANGES.get((state, happening), state)


def test_only_a_newer_epoch_ends_a_members_or_an_outsiders_state() -> None:
    for state in (State.MEMBER, State.ASIDE):
        assert [happening for happening in Happening if after(state, happening) is not state] == [
            Happening.NEWER_EPOCH
        ]


def test_the_table_names_no_change_that_is_none() -> None:
    assert set(TRANSITIONS) == set(CHANGES)
