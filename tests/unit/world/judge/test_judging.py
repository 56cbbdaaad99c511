"""Judging as entries come: what is certain, what waits, and what ending costs."""

import itertools
import sys
from collections import Counter
from collections.abc import Iterator

import msgspec
import pytest

from protocol.fence import Cause, May
from protocol.timeline import Entry, PoseSampled, PromiseBroken, Record, StrandFormed
from tests.support.histories.entries import Said
from tests.support.histories.fenced import EXACT, RUN, fence, formation, grant, order, run
from tests.support.logs.driving_logs import ORDER, entries, scenario
from world.judge.judgement import Court, Judge, judge
from world.judge.monitor import Monitor
from world.judge.moves import LAG_S, Intervals
from world.judge.rules.distances import MOVES_AT_ONCE
from world.judge.rules.evidence import FORMATIONS_KEPT
from world.judge.tally import Tally
from world.judge.truth.arrivals import STRANDS_KEPT

SHORT, LONG = 3_000, 12_000
UNDECIDED_MAX = MOVES_AT_ONCE + len(ORDER) * round(LAG_S / 0.1 + 2)


class Listener:
    """Hands entries to a court and keeps what it says at once."""

    def __init__(self) -> None:
        self.court = Court(EXACT, followers_sense=True)
        self._counts: Counter[str] = Counter()

    def hear(self, *said: Said) -> list[str]:
        """The invariants that are broken for certain after these entries."""
        found: list[str] = []
        for t_s, source, record in said:
            self._counts[source] += 1
            entry = Entry(n=self._counts[source], t_s=t_s, hlc="", record=record)
            found += [breach.broken.invariant for breach in self.court.hear(source, entry)]
        return found


def before(name: str) -> list[Said]:
    """The lawful run up to an entry, in order of time."""
    t_s = RUN[name][0]
    return [said for said in run() if said[0] < t_s]


def test_the_made_log_keeps_every_promise() -> None:
    judgement = judge(scenario(), entries(SHORT))
    assert judgement.breaches == ()
    assert judgement.path_m > 100.0


def test_what_is_kept_does_not_grow_with_the_entries() -> None:
    judging, most = Judge(scenario()), 0
    for source, entry in entries(LONG):
        judging.hear(source, entry)
        most = max(most, judging.undecided)
    assert most <= UNDECIDED_MAX


def formed(generation: int) -> Iterator[Said]:
    """Another epoch of robot 2, in which a strand forms."""
    epoch, t_s = 10_000 * generation + 2, float(generation)
    yield t_s, "world", fence(epoch, 0, cause=Cause.OUTSIDERS)
    yield t_s + 0.1, "r2", formation(epoch, 1, 1.2, 0.6, 0.0)
    yield t_s + 0.2, "world", fence(epoch, 1, May.ALL, named=1, members=3)


def test_what_is_kept_does_not_grow_with_the_formations() -> None:
    judging, tally, counts = Judge(scenario()), Tally(), Counter[str]()
    paths = []
    for t_s, source, record in itertools.chain.from_iterable(map(formed, range(1, 60))):
        counts[source] += 1
        for hear in (judging.hear, tally.hear):  # each reads the timeline for itself
            copy = msgspec.convert(msgspec.to_builtins(record), type(record))
            paths += [copy.laid] if isinstance(copy, StrandFormed) else []
            hear(source, Entry(n=counts[source], t_s=t_s, hlc="", record=copy))
    assert judging.judgement.breaches == ()
    holders = [sys.getrefcount(path) for path in paths]  # the collector lists no formations
    kept = sum(count > min(holders) for count in holders)
    assert 0 < kept <= FORMATIONS_KEPT + STRANDS_KEPT + 2


@pytest.mark.parametrize("many", [SHORT, LONG])
def test_ending_judges_the_last_seconds_only(many: int, monkeypatch: pytest.MonkeyPatch) -> None:
    judging, watch, watched = Judge(scenario()), Monitor.watch_all, list[float]()

    def counted(self: Monitor, intervals: Intervals) -> Iterator[tuple[float, PromiseBroken]]:
        watched.extend(intervals.ends_s)
        return watch(self, intervals)

    monkeypatch.setattr(Monitor, "watch_all", counted)
    for source, entry in entries(many):
        judging.hear(source, entry)
    during = len(watched)
    judging.close()
    assert 0 < len(watched) - during <= UNDECIDED_MAX / len(ORDER)
    assert watched == sorted(set(watched))


def test_an_order_waits_for_the_grant_that_comes_after_it_in_the_log() -> None:
    listener = Listener()
    grant_2, order_2 = RUN["grant 2"], RUN["order 2"]
    assert listener.hear(*before("grant 2")) == []
    decided = listener.court.undecided
    assert listener.hear(order_2) == []
    assert listener.court.undecided > decided
    assert listener.hear(grant_2, RUN["drive 2"]) == []
    assert listener.court.undecided == decided


def test_an_order_beyond_its_grant_is_certain_once_the_granter_records_a_later_time() -> None:
    listener = Listener()
    assert listener.hear(*before("grant 2"), RUN["order 2"]) == []
    late: Said = (2.93, "r1", grant(1.0))
    assert listener.hear(late) == ["F5"]
    assert listener.hear((9.0, "r1", grant(1.1))) == []


def test_an_order_beyond_its_grant_is_certain_at_the_end() -> None:
    listener = Listener()
    listener.hear(*before("grant 2"), RUN["order 2"])
    assert [breach.broken.invariant for breach in listener.court.close()] == ["F5"]


def test_an_unlawful_order_is_certain_at_once() -> None:
    listener = Listener()
    wrong: Record = order(3, (-1.2, 0.0), (-1.0, 0.0), turn=2)
    assert listener.hear(*before("formed"), (1.85, "world", wrong)) == ["F1"]


@pytest.mark.parametrize("lines", [1, 5, 17, 1000])
def test_entries_of_robots_may_be_recorded_late(lines: int) -> None:
    """So many lines later, each source in its own order: the judgement is the same."""
    court, counts = Court(EXACT, followers_sense=True), Counter[str]()
    keys = {"world": 0}
    delayed = sorted(enumerate(run()), key=lambda each: each[0] + keys.get(each[1][1], lines))
    for _, (t_s, source, record) in delayed:
        counts[source] += 1
        court.hear(source, Entry(n=counts[source], t_s=t_s, hlc="", record=record))
    court.close()
    assert court.breaches == ()


def test_a_body_that_moves_after_a_long_stand_is_judged_along_its_whole_way() -> None:
    """Its samples are further apart than moves wait: it is held to stand until the judge has to decide."""
    made, judging = scenario(), Judge(scenario())
    counts = Counter[str]()

    def sampled(t_s: float, robot: int, x_m: float, y_m: float) -> None:
        counts["world"] += 1
        pose = PoseSampled(robot=robot, x_m=x_m, y_m=y_m, heading_rad=0.0)
        judging.hear("world", Entry(n=counts["world"], t_s=t_s, hlc="", record=pose))

    places = {robot: (pose.x_m, pose.y_m) for robot, pose in enumerate(made.fleet.poses(), start=1)}
    for robot, place in places.items():
        sampled(0.0, robot, *place)
    x_m, y_m = places[1]
    for tenth in range(1, 3000):
        sampled(tenth / 10, 1, x_m + tenth / 1e6, y_m)
    sampled(300.0, 5, *places[4])
    judging.close()
    met = judging.judgement.least_separation
    assert (met.robot, met.other) == (4, 5)
    assert met.distance_m == pytest.approx(-0.2)
    assert judging.judgement.path_m == pytest.approx(1.0 + 0.002999)
