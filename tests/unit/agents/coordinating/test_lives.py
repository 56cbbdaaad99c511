"""What a coordinator does with reports of two lives of one robot."""

from protocol.fence import May
from tests.support.stages.coordinated import BEHIND, START, report, with_turns


def test_v18_a_place_that_another_life_tells_late_is_told_to_nobody_that_joins() -> None:
    """A robot that waits for news of its turn says where it stands; its next life may be heard first."""
    view = with_turns()
    assert [(at.x_m, at.y_m) for at in view.join.strand] == [START[1], BEHIND[2]]
    view.hear(2, report(2, BEHIND[2], life=22, turn=1))
    view.hear(2, report(2, START[2], number=3, turn=1))
    view.hear(3, report(3, BEHIND[3], number=3, turn=2, ended=2, placed=True))
    for _ in range(3):
        view.act()
    assert view.fence.may is May.NOBODY, "first robot 2 tells a place that is newer than its turn"


def test_what_a_life_says_late_changes_nothing_once_a_later_life_has_told_a_newer_turn() -> None:
    view = with_turns()
    view.hear(2, report(2, BEHIND[2], life=22, turn=2))
    view.act()
    view.hear(2, report(2, START[2], number=9, turn=1))
    view.act()
    assert view.answers[2].life == 22, "else the view waits for a life that is gone"
