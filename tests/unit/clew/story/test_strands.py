"""A strand comes into force by its fence; its links are up and its path known from then on."""

import itertools

import pytest

from clew.story.links import LinkChange, LinkState
from clew.story.story import Story
from protocol.timeline import Entry, LinkBroken
from tests.support.logs.logs import numbered
from tests.support.planned import planned
from tests.support.strands import Told, driving, formed, raised, strand

E = 10_002


def heard(*records: Told) -> Story:
    story = Story()
    for source, entry in numbered(records):
        story.hear(source, entry)
    return story


@pytest.mark.parametrize(
    "told", list(itertools.permutations([raised(E), ("r2", formed(E, 2, 1)), driving(E, 2, 1)]))
)
def test_a_strand_is_in_force_from_its_fence_on_in_whatever_order_entries_come(
    told: tuple[Told, ...],
) -> None:
    story = heard(*told)
    assert {epoch: each.formed.order for epoch, each in story.strands.formed.items()} == {E: (2, 1)}
    assert story.strands.formed[E].t_s == float(told.index(driving(E, 2, 1)))


def test_a_formation_whose_view_is_replaced_never_comes_into_force() -> None:
    story = heard(raised(E), ("r2", formed(E, 2, 1)), raised(20_001), driving(20_001, 1, 2))
    assert story.strands.formed == {}


def test_a_path_is_laid_by_the_formation_and_goes_on_to_the_leaders_targets() -> None:
    story = heard(*strand(1, 1, 2, 3), ("r1", planned(1)), ("r2", planned(7)))
    assert [(corner.x_m, corner.y_m) for corner in story.strands.paths()[1]] == [
        (0.0, 0.0), (1.0, 0.0), (2.0, 0.0), (1.0, 0.0),
    ]  # fmt: skip


def test_the_links_of_a_strand_are_up_when_it_comes_into_force() -> None:
    story = Story()
    broken = LinkBroken(neighbour=1, cause="silence", silent_s=1.0)
    for source, entry in (*numbered(strand(E, 2, 1)), ("r2", Entry(n=9, t_s=7.0, hlc="", record=broken))):
        story.hear(source, entry)
    for source, entry in numbered(strand(20_002, 3, 2, 1)):
        story.hear(source, Entry(n=20, t_s=10.0 + entry.t_s, hlc="", record=entry.record))
    assert story.links.changes == [
        LinkChange(2.0, 1, 2, LinkState.UP),
        LinkChange(7.0, 1, 2, LinkState.BROKEN),
        LinkChange(12.0, 2, 3, LinkState.UP),
        LinkChange(12.0, 1, 2, LinkState.UP),
    ]
