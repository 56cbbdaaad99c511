"""A strand that turns round, from the view of each robot."""

import pytest

from agents.events import LinkHeard
from agents.strand.strand import Strand
from protocol.frames import Vertex
from protocol.wire.messages import Reversal
from tests.support.stages.strand_stage import (
    KNOWN,
    ORDER,
    ahead,
    own,
    place,
    told_behind,
)


def reversal(end_m: float, *, cut_m: float = 0.0, back_by_m: float = 0.0) -> Reversal:
    return Reversal(cut_m=cut_m, end_m=end_m, back_by_m=back_by_m, turns=1, seen=b"")


def turned(strand: Strand, turn: Reversal, *, own_m: float, ahead_m: float, first_m: float) -> Strand:
    """The middle robot in the next epoch; the first state from ahead has the progress `first_m`."""
    assert strand.ahead is not None
    assert strand.behind is not None
    told = ahead(epoch=strand.epoch, progress_m=ahead_m, reversal=turn, path_from=0)
    strand.hear(LinkHeard(strand.ahead.neighbour, 1, told), 0.0)
    strand.pass_on_reversal()
    first = ahead(epoch=strand.epoch + 1, progress_m=first_m, path_from=0)
    return strand.turned_round(own_m, 0.0, first)


def test_a_standing_robot_passes_a_reversal_on_only_if_it_has_received_one() -> None:
    strand = place(2)
    strand.hear(LinkHeard(3, 1, ahead()), 0.0)
    strand.pass_on_reversal()
    before = told_behind(strand.tell(own(1.0), 0.0), 1).reversal
    strand.hear(LinkHeard(3, 2, ahead(reversal=reversal(2.0))), 0.1)
    strand.pass_on_reversal()
    assert (before, told_behind(strand.tell(own(1.0), 0.1), 1).reversal) == (None, reversal(2.0))


def test_a_reversal_is_not_passed_on_before_the_whole_path_is_known() -> None:
    strand, corner = place(2), Vertex(x_m=4.0, y_m=0.0, s_m=3.0)
    later = Vertex(x_m=5.0, y_m=0.0, s_m=4.0)
    strand.hear(LinkHeard(3, 2, ahead(path_from=KNOWN + 1, path=(later,), reversal=reversal(4.0))), 0.0)
    strand.pass_on_reversal()
    waits = strand.reversal
    strand.hear(LinkHeard(3, 1, ahead(path=(corner,))), 0.1)
    strand.pass_on_reversal()
    still_waits = strand.reversal
    strand.hear(LinkHeard(3, 3, ahead(path=(corner, later), reversal=reversal(4.0))), 0.2)
    strand.pass_on_reversal()
    assert (waits, still_waits, strand.reversal) == (None, None, reversal(4.0))


def test_in_the_next_epoch_order_and_path_are_reversed() -> None:
    strand = turned(place(2), reversal(2.0), own_m=1.0, ahead_m=2.0, first_m=2.0)
    assert (strand.epoch, strand.order, strand.laid_m) == (2, ORDER[::-1], 2.0)
    assert [link.neighbour for link in (strand.ahead, strand.behind) if link] == [1, 3]
    assert (strand.start_m, strand.authority_m, strand.grants.granted_m, strand.grants.behind_start_m) == (
        1.0,
        1.0,
        0.0,
        0.0,
    )
    assert strand.path.at(0.0) == place(2).path.at(2.0)
    assert strand.silent, "no state has arrived on its new links"
    assert strand.hear(LinkHeard(3, 9, ahead(authority_m=1.9)), 0.1) == []
    assert strand.authority_m == 1.0, "the grants of the old epoch are void"


def test_a_cut_path_ends_where_the_next_leader_stands() -> None:
    tail = place(1)
    tail.hear(LinkHeard(2, 1, ahead(progress_m=1.5, reversal=reversal(2.0, cut_m=0.4), path_from=0)), 0.0)
    tail.pass_on_reversal()
    leads = tail.turned_round(0.4, 0.0, None)
    assert (leads.laid_m, leads.start_m, leads.authority_m) == pytest.approx((1.6, 1.6, 1.6))
    assert leads.ahead is None
    assert leads.grants.granted_m == pytest.approx(0.5)
    assert leads.path.at(leads.path.end_m) == tail.path.at(0.4)


def test_a_strand_that_has_turned_round_has_no_uncertified_leg() -> None:
    second = turned(place(2), reversal(2.0), own_m=1.0, ahead_m=2.0, first_m=2.0)
    assert second.own_leg_m == second.start_m, "the robot that is ahead now has checked its leg up to here"
    third = turned(second, reversal(2.0), own_m=1.0, ahead_m=2.0, first_m=2.0)
    assert third.own_leg_m == third.start_m
