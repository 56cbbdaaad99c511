"""The formation of a strand that turns round."""

from dataclasses import replace

import pytest
from msgspec.structs import replace as changed

from agents.coordinating.agreeing import Turning
from agents.liveness.reason import Turnabout
from protocol.fence import Cause, Epoch, May
from protocol.frames import Point, Pose
from protocol.path import Path
from protocol.wire.view import Formation, Former, Report
from tests.support.stages import coordinated
from tests.support.stages.coordinated import BEGAN_S, START, TIMING, View

ENDED = Epoch(generation=2, robot=1, life=5)
VIEW = Epoch(generation=3, robot=1, life=5)
PATH = Path([Point(x_m=0.0, y_m=0.0), Point(x_m=2.0, y_m=0.0), Point(x_m=2.0, y_m=2.0)])
AT_M = {1: 4.0, 2: 3.0, 3: 1.5}
FORMATION = Formation(
    epoch=ENDED,
    life=1,
    turn=1,
    members=3,
    rank=0,
    s_m=4.0,
    place=Pose(x_m=2.0, y_m=2.0, heading_rad=0.0),
    ahead=None,
    behind=None,
    leg_is_driven=True,
    first=0,
    vertices=3,
    path=tuple(PATH),
)
TURNING = Turning(Turnabout(cut_m=0.5, end_m=4.0, back_by_m=1.0), FORMATION, PATH)


def report(robot: int, formers: tuple[Former, ...]) -> Report:
    place = Pose(x_m=float(robot), y_m=0.0, heading_rad=0.0)
    return Report(epoch=VIEW, life=robot, number=1, turn=0, place=place, formers=formers)


def stood_at(s_m: float, *, rank: int, epoch: Epoch = ENDED) -> Former:
    return Former(epoch=epoch, rank=rank, s_m=s_m, at=PATH.at(s_m))


def reports(**change: Former) -> dict[int, Report]:
    stood = {
        robot: Former(epoch=ENDED, rank=robot - 1, s_m=s_m, at=PATH.at(s_m)) for robot, s_m in AT_M.items()
    }
    stood |= {int(name[1:]): former for name, former in change.items()}
    return {robot: report(robot, (former,)) for robot, former in stood.items()}


def test_the_order_is_reversed_and_the_path_is_cut_and_goes_the_other_way() -> None:
    turned = TURNING.turned(reports())
    assert turned is not None
    order, (path, places_m) = turned
    assert order == (3, 2, 1)
    assert [(round(v.x_m, 9), round(v.y_m, 9)) for v in path] == [(2.0, 2.0), (2.0, 0.0), (0.5, 0.0)]
    assert places_m == pytest.approx({1: 0.0, 2: 1.0, 3: 2.5})
    assert path.end_m == pytest.approx(3.5)


@pytest.mark.parametrize("cut_m", [0.5, 2.5])  # it was heard of late; a robot between them has lied
def test_a_tail_that_leads_does_so_from_where_it_reports_to_stand(cut_m: float) -> None:
    turning = replace(TURNING, turnabout=Turnabout(cut_m=cut_m, end_m=4.0, back_by_m=0.0))
    turned = turning.turned(reports())
    assert turned is not None
    _, (path, places_m) = turned
    assert path.end_m == pytest.approx(2.5)
    assert places_m == pytest.approx({1: 0.0, 2: 1.0, 3: 2.5})


def test_a_strand_that_backs_up_keeps_its_path_up_to_where_its_tail_reports_to_stand() -> None:
    turning = replace(TURNING, turnabout=Turnabout(cut_m=2.5, end_m=4.0, back_by_m=0.2))
    turned = turning.turned(reports())
    assert turned is not None
    assert turned[1][0].end_m == pytest.approx(2.5), "the leader had heard of it further on"


def test_a_tail_that_tells_a_place_ahead_of_others_moves_none_of_theirs() -> None:
    turning = replace(TURNING, turnabout=Turnabout(cut_m=1.5, end_m=4.0, back_by_m=0.0))
    turned = turning.turned(reports(r3=stood_at(3.9, rank=2)))
    assert turned is not None
    assert turned[1][1] == pytest.approx({1: 0.0, 2: 1.0, 3: 0.1})


@pytest.mark.parametrize(
    "former",
    [
        stood_at(3.0, rank=1, epoch=VIEW),  # in another strand
        Former(epoch=ENDED, rank=1),  # in a draft
        stood_at(3.0, rank=2),  # two of one rank
    ],
)
def test_a_strand_of_which_not_all_stand_in_their_order_does_not_turn_round(former: Former) -> None:
    assert TURNING.turned(reports(r2=former)) is None


def test_a_strand_of_which_one_has_not_reported_does_not_turn_round() -> None:
    there = reports()
    del there[2]
    assert TURNING.turned(there) is None
    del there[3]
    assert TURNING.turned(there) is None, "nor without its tail"


def test_a_robot_that_tells_two_places_in_it_does_not_stand_for_one_that_has_not_reported() -> None:
    there = {**reports(), 3: report(3, (stood_at(1.5, rank=2), stood_at(3.0, rank=1)))}
    del there[2]  # its body is on the path between the others
    assert TURNING.turned(there) is None


def test_a_robot_that_was_not_in_it_does_not_keep_the_strand_from_turning_round() -> None:
    there = {**reports(), 4: report(4, ())}
    turned = TURNING.turned(there)
    assert turned is not None
    assert turned[0] == (3, 2, 1)


def test_no_strand_turns_round_in_a_view_in_which_a_robot_has_had_a_turn() -> None:
    """Former places count only where nobody has moved since: here all still tell theirs after a turn."""
    view = View(Cause.DEAD_END, turning=TURNING)

    def tell(robot: int, number: int, turn: int, *, ended: int = 0) -> None:
        said = coordinated.report(robot, START[robot], number=number, turn=turn, ended=ended)
        formers = reports()[robot].formers if robot in AT_M else ()
        view.hear(robot, changed(said, formers=formers))

    for robot in (1, 2, 4):
        tell(robot, 1, 0)
    view.act(until_s=BEGAN_S + TIMING.reports_s + 0.1)
    view.look()
    view.act()
    assert (view.fence.may, view.fence.robot) == (May.ONE, 2)
    tell(3, 1, 1)
    tell(2, 4, 1, ended=1)
    view.act()
    for robot in START:
        tell(robot, 5, 2)
    view.act()
    assert (view.fence.may, view.fence.turn) == (May.NOBODY, 2)
    assert set(view.drafted.order) == {*START}
