"""What a bound robot reports, and how it answers questions."""

import itertools
from dataclasses import dataclass, field

import pytest
from msgspec.structs import replace

from agents.body.driver import Driver
from agents.body.senses import Senses
from agents.commands import AskScan, Command, Say
from agents.liveness.timing import Timing
from agents.membership.places import OldPlace, Past
from agents.membership.reporting import Reporter
from agents.membership.turn import Ended
from agents.strand.memory import Memory
from protocol.fence import Epoch, Fence, May
from protocol.frames import Point, Pose
from protocol.path import Path
from protocol.wire.messages import Odometry, Phase, Scan
from protocol.wire.view import Answer, Former, Join, Question, Report
from tests.support.stages.one_step import under

EPOCH, BEFORE = Epoch(generation=2, robot=1, life=5), Epoch(generation=1, robot=1, life=5)
LIFE = 77
HERE, AHEAD = Pose(x_m=0.0, y_m=0.0, heading_rad=0.0), Pose(x_m=0.8, y_m=0.0, heading_rad=0.0)
MISSION = under("certified", robots=3, robot_radius_m=0.1, goal=Point(x_m=5.0, y_m=0.0))
TIMING = Timing()
PATH = Path([Point(x_m=0.0, y_m=0.0), Point(x_m=0.8, y_m=0.0)])
DRIVEN = Past((OldPlace(BEFORE, 1, 0.0, PATH),))


@dataclass
class Bound:
    """A bound robot that stands, with its odometry."""

    past: Past = field(default_factory=Past)
    fence: Fence = Fence(epoch=EPOCH)  # noqa: RUF009 - it is frozen

    def __post_init__(self) -> None:
        self.driver = Driver(speed_mps=0.3)
        self.senses = Senses(MISSION, self.driver)
        self.n = self.answers = 0
        self.reporter = Reporter(
            epoch=EPOCH,
            life=LIFE,
            mission=MISSION,
            timing=TIMING,
            memory=Memory(MISSION),
            past=self.past,
            heard_at_s=0.0,
        )

    def at(self, now_s: float, *, turn: int = 0, pose: Pose = HERE) -> list[Command]:
        """Odometry comes; returns what the robot does."""
        self.n += 1
        self.fence = replace(self.fence, turn=turn)
        told = Odometry(
            n=self.n, t_s=now_s, pose=pose, moving=False, finished=0, fence=self.fence, phase=Phase.RUNNING
        )
        self.driver.hear(told)
        return self.reporter.act(self.driver, self.senses, now_s)

    def answered(self, now_s: float, heard: int, **more: object) -> None:
        self.answers += 1
        answer = Answer(epoch=EPOCH, life=LIFE, heard=heard)
        self.reporter.hear(replace(answer, **more), self.answers, now_s)

    def scan(self, *, fence: Fence | None = None, ahead_m: float | None = None) -> None:
        """A scan taken here; with a thing in front at some distance."""
        ranges = [MISSION.range_m_max] * MISSION.directions
        if ahead_m is not None:
            middle = MISSION.directions // 2
            ranges[middle - 20 : middle + 20] = [ahead_m] * 40
        self.senses.hear(Scan(t_s=0.0, pose=HERE, fence=fence or self.fence, ranges_m=tuple(ranges)))


def reports(commands: list[Command]) -> list[Report]:
    said = [each.said for each in commands if isinstance(each, Say)]
    return [each for each in said if isinstance(each, Report)]


# --- repeating ------------------------------------------------------------------------------------------


def test_a_report_goes_to_the_coordinator_and_is_repeated_until_it_is_answered_and_then_less_often() -> None:
    bound = Bound()
    (first,) = reports(bound.at(0.0))
    assert [each.robot for each in bound.at(0.1) if isinstance(each, Say)] == [EPOCH.robot]
    bound.answered(0.15, first.number)
    times: list[float] = []
    for tenth in range(2, 32):
        for report in reports(bound.at(tenth / 10)):
            times.append(tenth / 10)
            bound.answered(tenth / 10 + 0.05, report.number)
    gaps_s = {round(after - before, 6) for before, after in itertools.pairwise(times)}
    assert gaps_s == {TIMING.ping_s}


def test_a_report_that_says_the_same_keeps_its_number_and_one_with_news_has_the_next() -> None:
    bound = Bound()
    numbers = [reports(bound.at(tenth / 10))[0].number for tenth in range(3)]
    elsewhere = replace(HERE, x_m=0.01)
    numbers += [report.number for report in reports(bound.at(0.3, pose=elsewhere))]
    assert numbers == [1, 1, 1, 2]


def test_an_answered_report_that_is_repeated_in_vain_is_repeated_more_often() -> None:
    bound = Bound()
    (first,) = reports(bound.at(0.0))
    bound.answered(0.05, first.number)
    times = [tenth for tenth in range(1, 9) if reports(bound.at(tenth / 10))]
    assert times == [5, 6, 7, 8]


# --- places ---------------------------------------------------------------------------------------------


def test_a_place_is_told_with_the_turn_of_the_odometry_that_it_was_read_from() -> None:
    bound = Bound()
    (first,) = reports(bound.at(0.0, turn=3))
    assert (first.place, first.turn) == (HERE, 3)


def test_a_later_turn_of_others_is_no_news_of_a_robot_that_has_not_had_one() -> None:
    bound = Bound()
    bound.at(0.0, turn=1)
    assert {report.turn for tenth in range(1, 9) for report in reports(bound.at(tenth / 10, turn=tenth))} == {
        1
    }


def test_after_a_turn_of_its_own_it_tells_its_place_from_a_later_one() -> None:
    bound = Bound()
    bound.at(0.0, turn=1)
    bound.answered(0.05, 1, after_turn=2)
    bound.reporter.end_turn(Ended(2, placed=True))
    told = [reports(bound.at(0.1 * turn, turn=turn))[-1] for turn in (2, 3)]
    assert [(report.turn, report.ended, report.placed) for report in told] == [(2, 2, True), (3, 2, True)]


def test_a_robot_that_has_driven_by_its_own_steps_has_left_its_former_places() -> None:
    bound = Bound(DRIVEN)
    assert [former.epoch for former in reports(bound.at(0.0))[0].formers] == [BEFORE]
    bound.reporter.leave_places()
    assert reports(bound.at(0.1))[0].formers == ()


def test_where_the_strand_ends_serves_for_the_turn_that_it_was_told_for_until_that_has_ended() -> None:
    bound = Bound()
    join = Join(turn=4, strand=(), waiting=(), robots=(), line=(), last_leg=0)
    bound.answered(0.0, 0, join=join)
    assert [bound.reporter.join(turn) for turn in (3, 4, 5)] == [None, join, None]
    bound.reporter.end_turn(Ended(4, placed=False))
    assert bound.reporter.join(4) is None


def test_an_older_answer_changes_nothing() -> None:
    bound = Bound()
    bound.answered(0.0, 0, rank=1)
    newest = bound.reporter.answer
    bound.reporter.hear(Answer(epoch=EPOCH, life=LIFE, heard=9), 1, 1.0)
    assert bound.reporter.answer == newest


# --- questions ------------------------------------------------------------------------------------------


def leg_asked(**more: object) -> Question:
    question = Question(number=1, place=AHEAD, others=(Point(x_m=0.8, y_m=0.0),))
    return replace(question, **more)


def test_it_looks_at_its_leg_when_it_is_asked_and_answers_once() -> None:
    bound = Bound()
    bound.at(0.0)
    bound.answered(0.05, 1, question=leg_asked())
    assert [each for each in bound.at(0.1) if isinstance(each, AskScan)]
    bound.scan()
    (told,) = reports(bound.at(0.2))
    assert told.look is not None
    assert (told.look.number, told.look.clear, told.look.driven) == (1, True, False)
    assert not [each for each in bound.at(0.5) if isinstance(each, AskScan)]


def test_a_leg_with_something_on_it_is_not_clear() -> None:
    bound = Bound()
    bound.at(0.0)
    bound.answered(0.05, 1, question=leg_asked())
    bound.at(0.1)
    bound.scan(ahead_m=0.4)
    (told,) = reports(bound.at(0.2))
    assert told.look is not None
    assert not told.look.clear


def test_a_scan_of_another_turn_answers_nothing() -> None:
    bound = Bound()
    bound.at(0.0)
    bound.answered(0.05, 1, question=leg_asked())
    bound.at(0.1)
    bound.scan(fence=Fence(epoch=EPOCH, turn=1, may=May.NOBODY))
    assert [report.look for report in reports(bound.at(0.2))] in ([], [None])


def leg_to(ahead_m: Point) -> Question:
    """The robot ahead has driven the leg, and stands off that place of its path."""
    former = Former(epoch=BEFORE, rank=0, s_m=0.8, at=ahead_m, leg_from_m=0.0)
    return leg_asked(formers=(former,))


def test_a_leg_that_was_driven_is_told_without_a_look() -> None:
    bound = Bound(DRIVEN)
    bound.at(0.0)
    bound.answered(0.05, 1, question=leg_to(Point(x_m=0.8, y_m=0.0)))
    commands = bound.at(0.1)
    assert not [each for each in commands if isinstance(each, AskScan)]
    (told,) = reports(commands)
    assert told.look is not None
    assert (told.look.clear, told.look.driven) == (True, True)


@pytest.mark.parametrize(("share", "looks"), [(0.25, False), (0.3, True), (0.9, True)])
def test_a_leg_of_a_robot_that_stands_further_beside_its_place_than_one_drive_is_off_is_looked_at(
    share: float, looks: bool
) -> None:
    bound = Bound(DRIVEN)
    bound.at(0.0)
    bound.answered(0.05, 1, question=leg_to(Point(x_m=0.8, y_m=share * MISSION.mu0_m)))
    assert bool([each for each in bound.at(0.1) if isinstance(each, AskScan)]) == looks


def test_asked_for_the_nearest_obstacle_it_tells_the_nearest_hit_that_is_no_robot() -> None:
    for others, nearest_m in (((), 0.4), ((Point(x_m=0.5, y_m=0.0),), None)):
        bound = Bound()
        bound.at(0.0)
        bound.answered(0.05, 1, question=Question(number=1, others=others))
        bound.at(0.1)
        bound.scan(ahead_m=0.4)
        (told,) = reports(bound.at(0.2))
        assert told.look is not None
        assert told.look.obstacle_m == pytest.approx(nearest_m, abs=0.02)
