"""Robots of a strand that does not fold back keep apart, however they drive; others do not.

In these bounds its ends alone decide: without the part of the rule that is of legs nothing breaks.
"""

import pytest

from tests.model.folding.strands import are_near, folds_back, reached, strands

SHORT = [(3, 7, 423, 4_917, 2), (4, 8, 567, 2_869, 13)]
"""Robots, corners; strands that do not fold back, their states; those that break without the rule."""
ONWARD = 3


@pytest.mark.parametrize(("robots", "corners", "lying_apart", "states", "_"), SHORT)
def test_robots_of_a_strand_that_does_not_fold_back_keep_apart_and_where_it_stops_it_does_not_either(
    robots: int, corners: int, lying_apart: int, states: int, _: int
) -> None:
    """So a strand that turns round where it has stopped needs no look at its legs."""
    count = found = 0
    for path, places in strands(robots, corners, onward=ONWARD):
        if folds_back(path, places):
            continue
        all_states = reached(path, places)
        assert not [state for state in all_states if are_near(path, state.places)]
        assert not [state for state in all_states if folds_back(path, state.places)]
        count, found = count + 1, found + len(all_states)
    assert (count, found) == (lying_apart, states)


@pytest.mark.parametrize(("robots", "corners", "_", "__", "broken"), SHORT)
def test_robots_of_a_strand_that_folds_back_come_too_near(
    robots: int, corners: int, _: int, __: int, broken: int
) -> None:
    folded = [
        (path, places)
        for path, places in strands(robots, corners, onward=ONWARD)
        if folds_back(path, places) and not are_near(path, places)
    ]
    too_near = [
        path
        for path, places in folded
        if any(are_near(path, state.places) for state in reached(path, places))
    ]
    assert len(too_near) == broken
