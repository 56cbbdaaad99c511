"""The phases of a coordinator: every pair."""

import itertools

import pytest

from agents.coordinating.phases import PHASES, Phase

MAY_FOLLOW = {
    (Phase.GATHERING, Phase.LOOKING),
    (Phase.GATHERING, Phase.CLOSING),  # the strand turns round: nobody has to look
    (Phase.LOOKING, Phase.TURNING),
    (Phase.LOOKING, Phase.GATHERING),
    (Phase.TURNING, Phase.CLOSING),
    (Phase.TURNING, Phase.GATHERING),
    (Phase.CLOSING, Phase.FORMED),
    (Phase.CLOSING, Phase.GATHERING),
}
"""From the design, not from the code."""


@pytest.mark.parametrize(("before", "after"), list(itertools.product(Phase, Phase)))
def test_every_phase_is_followed_by_those_that_may_follow_it(before: Phase, after: Phase) -> None:
    assert (after in PHASES[before]) is ((before, after) in MAY_FOLLOW)


def test_a_robot_that_is_lost_begins_every_view_again_that_has_not_formed() -> None:
    unformed = set(Phase) - {Phase.FORMED, Phase.GATHERING}
    assert all(Phase.GATHERING in PHASES[phase] for phase in unformed)


def test_nothing_follows_a_formation() -> None:
    assert PHASES[Phase.FORMED] == frozenset()
