"""The real cores and the real world as a system; short forms of what `clew explore` does."""

from functools import cache

import pytest
from msgspec.structs import replace

from clew.explore import fleet
from clew.explore.explorable import Fault
from clew.explore.explore import explore
from clew.explore.fleet import Fleet
from clew.explore.moments import Moment
from clew.explore.search import Ended, Exploration, Explored, Strike, deepen, retell
from clew.explore.setting import NEVER_TICKS, SETTINGS, Kind, adjusted
from clew.explore.without import RULES
from protocol.errors import UsageError
from protocol.fence import May
from protocol.process.tokens import TokenCame
from tests.support.long import long

START = SETTINGS["start"]
SHORT = replace(START, deliveries=4, settle_ticks=50, delays_ticks=(5,), restarts_ticks=(5, NEVER_TICKS))


@cache
def explored() -> Explored:
    """All schedules with one fault, to read."""
    return Exploration(Fleet(SHORT), 1).run(lambda: True)


def after(fleet: Fleet, moment: Moment, ticks: int) -> Moment:
    while moment.ticks < ticks:
        following = fleet.follow(moment)
        assert following is not None
        moment = following
    return moment


def test_without_faults_three_robots_form_a_strand_and_drive() -> None:
    fleet = Fleet(START)
    moment = after(fleet, fleet.start(), 100)
    fence = fleet.cores.fences[moment.fence]
    assert (fence.may, fence.members) == (May.ALL, 3)
    poses = fleet.cores.world(moment.world).bodies.place_m
    assert all(x_m > start[0] + 0.5 for (x_m, _), start in zip(poses, START.places, strict=True))


def test_a_fleet_goes_on_from_equal_moments_in_the_same_way() -> None:
    assert Exploration(Fleet(SHORT), 1).run(lambda: True) == explored()


def test_all_schedules_with_a_fault_in_the_first_deliveries_keep_all_promises() -> None:
    found = explored()
    assert (found.ended, found.broken) == (Ended.COMPLETE, None)
    assert found.schedules[1] > 3 * SHORT.deliveries


def test_remembered_steps_are_the_computed_ones() -> None:
    fleet = Fleet(SHORT)
    first = after(fleet, fleet.start(), 50)
    computed = fleet.cores.computed
    assert after(fleet, fleet.start(), 50) == first
    assert fleet.cores.computed == computed


class StepByStep(Fleet):
    """Without what makes an exploration fast: every moment is compared, and every step taken alone."""

    def _settled(self, state: Moment) -> Moment:
        cores = self.cores
        robots = tuple(
            process and process._replace(core=cores.settle_robot(process.core)) for process in state.robots
        )
        return state._replace(robots=robots, world=cores.settle_world(state.world))

    def hurry(self, state: Moment) -> Moment | None:
        return self.follow(state)


@pytest.mark.parametrize(
    ("deliveries", "forgets_from"),
    [(1, 0), *long([(SHORT.deliveries, 0), (SHORT.deliveries, fleet.FORGETS_FROM)])],
)
def test_an_exploration_that_hurries_and_forgets_covers_the_same_schedules(
    deliveries: int, forgets_from: int, monkeypatch: pytest.MonkeyPatch
) -> None:
    setting = replace(SHORT, deliveries=deliveries)
    slow = Exploration(StepByStep(setting), 1).run(lambda: True)
    monkeypatch.setattr(fleet, "FORGETS_FROM", forgets_from)
    fast = Exploration(Fleet(setting), 1).run(lambda: True)
    assert (fast.ended, fast.schedules) == (slow.ended, slow.schedules)
    assert fast.states < slow.states / 5


def test_an_exploration_that_hurries_finds_the_same_breach(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("world.bodies.body.obeys", lambda *_: True)  # without F1
    setting = replace(RULES["F1"].setting, settle_ticks=25)
    (*_, slow), (*_, fast) = (deepen(kind(setting), 2, lambda: True) for kind in (StepByStep, Fleet))
    assert slow.broken is not None
    assert fast.broken is not None
    assert (fast.faults, fast.broken.promise) == (slow.faults, slow.broken.promise)
    assert fast.broken.promise == "F1"


def test_a_lost_letter_does_not_arrive_and_a_late_one_arrives_later() -> None:
    fleet = Fleet(START)
    start = fleet.start()
    while not start.now or not start.now[0].is_fault_prone:
        following = fleet.follow(start)
        assert following is not None
        start = following
    letter = start.now[0]
    lost = fleet.strike(start, Fault(Kind.LOSE))
    late = fleet.strike(start, Fault(Kind.LATE, 0, 5))
    twice = fleet.strike(start, Fault(Kind.TWICE, 0, 5))
    assert letter not in lost.now
    assert (late.now, late.later) == (lost.now, ((start.ticks + 5, letter),))
    assert (twice.robots != lost.robots, twice.later) == (True, late.later)


def test_a_killed_robot_is_down_until_it_is_started_again_in_another_life() -> None:
    fleet = Fleet(START)
    moment = after(fleet, fleet.start(), 50)
    killed = fleet.strike(moment, Fault(Kind.KILL, 2, 10))
    assert [process is None for process in killed.robots] == [False, True, False]
    back = after(fleet, killed, 70)
    assert back.lives == (1, 2, 1)
    assert back.robots[1] is not None


def test_a_robot_that_is_cut_off_is_heard_again_later() -> None:
    fleet = Fleet(START)
    moment = after(fleet, fleet.start(), 50)
    cut = after(fleet, fleet.strike(moment, Fault(Kind.CUT, 2, 25)), 70)
    process, same = cut.robots[1], moment.robots[1]
    assert process is not None
    assert same is not None
    assert process.now_s == same.now_s
    healed = after(fleet, cut, 90).robots[1]
    assert healed is not None
    assert healed.now_s > 1.5


def test_a_robot_that_dies_while_another_one_is_cut_off_is_not_seen_after_that() -> None:
    fleet = Fleet(START)
    cut = fleet.strike(after(fleet, fleet.start(), 50), Fault(Kind.CUT, 2, 100))
    killed = fleet.strike(cut, Fault(Kind.KILL, 3, NEVER_TICKS))
    came = [fleet.cores.things[letter.thing] for _, letter in killed.later]
    assert TokenCame(1, "1") in came
    assert TokenCame(3, "1") not in came


def test_a_world_that_is_started_again_raises_the_fence() -> None:
    fleet = Fleet(START)
    moment = after(fleet, fleet.start(), 50)
    again = fleet.strike(moment, Fault(Kind.WORLD))
    before, now = (fleet.cores.fences[each.fence] for each in (moment, again))
    assert now.epoch == before.epoch.next(0, 0)


def test_a_schedule_is_retold_with_its_faults() -> None:
    fleet = Fleet(SHORT)
    rank = fleet.rank(fleet.start())
    told = list(retell(fleet, [Strike(rank, Fault(Kind.WORLD))]))
    assert told[0][2] == Fault(Kind.WORLD)
    assert all(fault is None for _, _, fault in told[1:])


def test_a_setting_has_other_bounds_if_they_are_asked_for() -> None:
    two = adjusted(START, robots=2, deliveries=5, skips=3)
    assert (len(two.places), two.deliveries, two.skips) == (2, 5, 3)
    assert adjusted(START) == START
    with pytest.raises(UsageError, match="the setting start has 3 robots, not 9"):
        adjusted(START, robots=9)


def test_time_that_is_up_is_said() -> None:
    *_, last = explore(START, 2, 0.0)
    assert last.explored.ended is Ended.TIME


@pytest.mark.parametrize("name", SETTINGS)
def test_every_setting_keeps_all_promises_without_faults(name: str) -> None:
    found = Exploration(Fleet(SETTINGS[name]), 0).run(lambda: True)
    assert (found.ended, found.schedules) == (Ended.COMPLETE, (1,))
