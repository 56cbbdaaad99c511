"""Where hits of a scan count as robots of the strand: F6. Each test is a schedule of the design."""

from agents.events import LinkHeard
from agents.strand.strand import Strand
from protocol.frames import Point
from tests.support.stages.strand_stage import (
    KEEP_M,
    ahead,
    behind,
    leading,
    own,
    place,
)


def spans(strand: Strand) -> list[tuple[float, float]]:
    """From where to where robots of the strand may be seen, along x."""
    return [(float(ground[0][0]), float(ground[-1][0])) for ground in strand.robots_in_sight]


def test_v22_a_body_right_behind_is_a_robot_of_the_strand_only_where_the_one_behind_may_be() -> None:
    strand = leading()  # at x = 3 m; robot 2 at 2 m, the tail at 1 m
    assert spans(strand) == [(2.0, 2.0)]
    strand.hear(LinkHeard(2, 1, behind(progress_m=1.0)), 0.1)
    strand.tell(own(3.0), 0.2)  # it has driven a metre, to x = 4 m
    assert spans(strand) == [(2.0, 4.0 - KEEP_M)]
    strand.hear(LinkHeard(2, 2, behind(progress_m=1.5, t_s=0.3)), 0.3)
    assert spans(strand) == [(2.5, 4.0 - KEEP_M)], "the ground that it has left is not its own any more"


def test_of_the_robot_ahead_hits_count_from_where_it_was_last_heard_on() -> None:
    strand = place(2)  # at x = 2 m, between robot 3 at 3 m and robot 1 at 1 m
    assert spans(strand)[1] == (3.0, 3.0)
    strand.path.extend(Point(x_m=7.0, y_m=0.0))
    assert spans(strand)[1] == (3.0, 7.0)
    strand.hear(LinkHeard(3, 1, ahead(progress_m=4.0)), 0.1)
    assert spans(strand)[1] == (5.0, 7.0)
