"""A follower that stays blocked: the strand dissolves, and all robots line up again from where they stand.

The door of `launch/scenarios/door.toml` closes later here, while the strand drives through it. In these runs
it does not come to rest on a robot: then there would be no way out without contact.
"""

from functools import cache
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

import pytest

from clew.rehearsal.rehearsal import Rehearsal
from protocol.faults.plan import NO_FAULTS, Plan, uniform
from protocol.root import ROOT
from protocol.timeline import (
    Entry,
    FenceChanged,
    OrderAccepted,
    Record,
    RobotArrived,
    StrandDissolved,
    StrandJoined,
    ViewJoined,
)
from tests.support.faults import injected
from tests.support.long import long
from tests.support.strands import strand
from world.judge.ending import Ending
from world.judge.judgement import judge
from world.judge.tally import Tally
from world.scenario.scenario import load

DOOR = ROOT / "launch" / "scenarios" / "door.toml"
PERFECT = NO_FAULTS
LOSSY = uniform(delay_s_max=0.1, loss=0.15, repeat=0.1)
OTHER_OPENING = "[3.2, 3.1], [3.0, 3.1]"
WALLED_UP = "[3.2, 3.9], [3.0, 3.9]"  # up to the wall above it
TRACK = "track = [[0.5, 3.25, 1.0], [3.5, 3.25, 2.0]]"
WALLS_FROM, WALLS_TO = '[[obstacle]]\nshape = "polygon" # the wall below', "[[moving]]"


@cache
def rehearsed(*changes: tuple[str, str], seed: int = 1, plan: Plan = PERFECT) -> Rehearsal:
    """The door's scenario with some of its text changed, rehearsed to its end: to read."""
    text = DOOR.read_text(encoding="utf-8")
    for old, new in changes:
        assert text.count(old) == 1, old
        text = text.replace(old, new)
    with TemporaryDirectory() as folder:
        changed = Path(folder, "door.toml")
        changed.write_text(text, encoding="utf-8")
        return Rehearsal(load(str(changed)), seed, plan).run()


def queue(robots: int, spacing_m: float) -> list[tuple[str, str]]:
    """Changes for a queue of robots with this spacing, and with room behind the last one."""
    start_x_m = max(1.0, spacing_m * (robots - 1) + 0.2)
    return [
        ("robots = 3", f"robots = {robots}"),
        ("spacing_m = 0.3", f"spacing_m = {spacing_m}"),
        ("start = [1.0, 2.0, 0.0]", f"start = [{start_x_m}, 2.0, 0.0]"),
    ]


def closing(from_s: float) -> tuple[str, str]:
    """The door closes within three seconds and stays closed."""
    return TRACK, f"track = [[{from_s}, 3.25, 1.0], [{from_s + 3.0}, 3.25, 2.0]]"


def entry(n: int, record: Record) -> Entry:
    return Entry(n=n, t_s=float(n), hlc="", record=record)


def is_view_after(record: object, dissolved: StrandDissolved) -> bool:
    return isinstance(record, ViewJoined) and record.epoch > dissolved.epoch


def is_fence_after(record: object, dissolved: StrandDissolved) -> bool:
    return isinstance(record, FenceChanged) and record.epoch > dissolved.epoch


def dissolutions(rehearsal: Rehearsal) -> list[StrandDissolved]:
    return [entry.record for _, entry in rehearsal.entries if isinstance(entry.record, StrandDissolved)]


@pytest.mark.parametrize(
    ("robots", "spacing_m", "from_s", "cut_off"),
    [(3, 0.8, 4.0, 3), *long([(3, 0.7, 3.07, 2)])],
)
def test_a_strand_that_a_door_cuts_in_two_lines_up_again_and_takes_the_other_opening(
    robots: int, spacing_m: float, from_s: float, cut_off: int
) -> None:
    rehearsal = rehearsed(*queue(robots, spacing_m), closing(from_s))
    assert [each.blocked for each in dissolutions(rehearsal)] == [cut_off]
    assert judge(rehearsal.world.scenario, rehearsal.entries).breaches == ()
    assert rehearsal.world.ending is Ending.ARRIVED


@pytest.mark.long
def test_loss_and_delay_only_cost_time() -> None:
    rehearsal = rehearsed(*queue(3, 0.8), closing(4.0), seed=4, plan=LOSSY)
    assert injected(rehearsal)["drop"] > 100
    assert judge(rehearsal.world.scenario, rehearsal.entries).breaches == ()
    assert rehearsal.world.ending is Ending.ARRIVED


@pytest.mark.long  # in the short form a body that stays in the way shows it: `test_stranded.py`
def test_without_another_way_the_one_in_front_arrives_and_the_others_are_stranded() -> None:
    """They try until the door has stayed shut for long between two views."""
    in_time = ("time_s_max = 120.0", "time_s_max = 400.0")
    changes = [*queue(3, 0.7), closing(3.07), (OTHER_OPENING, WALLED_UP), in_time]
    rehearsal = rehearsed(*changes)
    world = rehearsal.world
    assert len(dissolutions(rehearsal)) == 1
    assert world.ending is Ending.STRANDED
    assert (world.tally.arrived, world.tally.stranded_among(world.attendance.living)) == ({1}, [2, 3])
    assert judge(world.scenario, rehearsal.entries).breaches == ()


@pytest.mark.long  # in the short form a door that cuts the strand in two shows it
@pytest.mark.parametrize("from_s", [2.25, 0.5])
def test_the_strand_drives_around_an_obstacle_that_stops_on_its_path(from_s: float) -> None:
    text = DOOR.read_text(encoding="utf-8")
    walls = text[text.index(WALLS_FROM) : text.index(WALLS_TO)]
    door = text[text.index('shape = "polygon"\nvertices_m = [[0.0, -0.5]') : text.index("track = ")]
    ball = (door, 'shape = "circle"\nradius_m = 0.15\n')
    track = (TRACK, f"track = [[{from_s}, 3.2, 3.5], [{from_s + 3.0}, 3.2, 2.0]]")
    rehearsal = rehearsed((walls, ""), ball, track, *queue(3, 0.9))
    assert len(dissolutions(rehearsal)) == 1
    assert judge(rehearsal.world.scenario, rehearsal.entries).breaches == ()
    assert rehearsal.world.ending is Ending.ARRIVED


def test_a_robot_that_had_arrived_arrives_again_in_the_new_strand() -> None:
    rehearsal = rehearsed(*queue(3, 0.8), closing(4.0))
    (dissolved,) = dissolutions(rehearsal)
    of_leader = [entry.record for source, entry in rehearsal.entries if source == "r1"]
    arrived = [index for index, record in enumerate(of_leader) if isinstance(record, RobotArrived)]
    joined = [index for index, record in enumerate(of_leader) if isinstance(record, StrandJoined)]
    ends = next(index for index, record in enumerate(of_leader) if is_view_after(record, dissolved))
    assert arrived[0] < ends < joined[1] < arrived[1]
    assert rehearsal.world.tally.arrived == {1, 2, 3}


def test_a_robot_in_a_new_strand_has_not_arrived_in_it_yet() -> None:
    tally = Tally()
    for source, record in strand(10_001, 1):
        tally.hear(source, entry(1, record))
    tally.hear("r1", entry(1, RobotArrived(progress_m=1.0)))
    assert tally.arrived == {1}
    tally.hear("r1", entry(2, ViewJoined(epoch=20001)))
    assert tally.arrived == set()


def test_orders_after_a_dissolution_without_its_fence_break_f1() -> None:
    rehearsal = rehearsed(*queue(3, 0.8), closing(4.0))
    (dissolved,) = dissolutions(rehearsal)
    unsaid = [line for line in rehearsal.entries if not is_fence_after(line[1].record, dissolved)]
    broken = {breach.broken.invariant for breach in judge(rehearsal.world.scenario, unsaid).breaches}
    assert "F1" in broken


@pytest.mark.parametrize("more", [{}, *long([{"seed": 4, "plan": LOSSY}])])
def test_the_orders_of_one_epoch_end_before_those_of_the_next_begin(more: dict[str, Any]) -> None:
    rehearsal = rehearsed(*queue(3, 0.8), closing(4.0), **more)
    orders = [entry.record for _, entry in rehearsal.entries if isinstance(entry.record, OrderAccepted)]
    drives = [(order.epoch, order.turn) for order in orders if order.target is not None]
    assert drives == sorted(drives)
    assert len({epoch for epoch, _ in drives}) > 1
