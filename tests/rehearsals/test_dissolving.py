"""A follower that stays blocked: the strand dissolves, and all robots line up again from where they stand.

The door of `launch/scenarios/door.toml` closes later here, while the strand drives through it. In these runs
it does not come to rest on a robot: then there would be no way out without contact.
"""

from functools import cache
from pathlib import Path
from tempfile import TemporaryDirectory

import pytest
from agents.membership.lining import Lining
from hypothesis import given, settings
from hypothesis import strategies as st

from agents.body.driver import Driver
from clew.rehearsal.rehearsal import Rehearsal
from protocol.faults.plan import NO_FAULTS, Plan, uniform
from protocol.frames import Pose
from protocol.mission import Law
from protocol.root import ROOT
from protocol.timeline import Entry, OrderAccepted, RobotArrived, StrandDissolved, StrandFormed
from protocol.wire.messages import Dissolution, Muster, Odometry, Phase
from tests.support.faults import injected
from tests.support.stages.one_step import under
from tests.support.stages.turning_stage import ORDER, TurningStage
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


TIME_FOR_ALL_ORDERS = ("time_s_max = 120.0", "time_s_max = 240.0")  # all orders have been tried after 160 s


def closing(from_s: float) -> tuple[str, str]:
    """The door closes within three seconds and stays closed."""
    return TRACK, f"track = [[{from_s}, 3.25, 1.0], [{from_s + 3.0}, 3.25, 2.0]]"


def entry(n: int, record: RobotArrived | StrandFormed) -> Entry:
    return Entry(n=n, t_s=float(n), hlc="", record=record)


def dissolutions(rehearsal: Rehearsal) -> list[StrandDissolved]:
    return [entry.record for _, entry in rehearsal.entries if isinstance(entry.record, StrandDissolved)]


@pytest.mark.parametrize(
    ("robots", "spacing_m", "from_s", "cut_off"),
    [(3, 0.7, 3.07, 2), (3, 0.8, 4.0, 3)],
)
def test_a_strand_that_a_door_cuts_in_two_lines_up_again_and_takes_the_other_opening(
    robots: int, spacing_m: float, from_s: float, cut_off: int
) -> None:
    rehearsal = rehearsed(*queue(robots, spacing_m), closing(from_s))
    assert [each.blocked for each in dissolutions(rehearsal)] == [cut_off]
    assert judge(rehearsal.world.scenario, rehearsal.entries).breaches == ()
    assert rehearsal.world.ending is Ending.ARRIVED


def test_loss_and_delay_only_cost_time() -> None:
    rehearsal = rehearsed(*queue(3, 0.8), closing(4.0), seed=4, plan=LOSSY)
    assert injected(rehearsal)["drop"] > 100
    assert judge(rehearsal.world.scenario, rehearsal.entries).breaches == ()
    assert rehearsal.world.ending is Ending.ARRIVED


def test_without_another_way_the_run_ends_with_route_lost() -> None:
    changes = [*queue(3, 0.7), closing(3.07), (OTHER_OPENING, WALLED_UP), TIME_FOR_ALL_ORDERS]
    rehearsal = rehearsed(*changes)
    assert len(dissolutions(rehearsal)) == 1
    assert rehearsal.world.ending is Ending.ROUTE_LOST
    assert rehearsal.world.tally.route_lost is not None
    assert "no way to a place behind robot" in rehearsal.world.tally.route_lost[1].reason
    assert judge(rehearsal.world.scenario, rehearsal.entries).breaches == ()


@pytest.mark.parametrize("from_s", [0.5, 2.25])
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
    formed = [index for index, record in enumerate(of_leader) if isinstance(record, StrandFormed)]
    assert arrived[0] < of_leader.index(dissolved) < formed[1] < arrived[1]
    assert rehearsal.world.tally.arrived == {1, 2, 3}


def test_a_robot_in_a_new_strand_has_not_arrived_in_it_yet() -> None:
    tally = Tally()
    tally.hear("r1", entry(1, RobotArrived(progress_m=1.0)))
    assert tally.arrived == {1}
    tally.hear("r1", entry(2, StrandFormed(epoch=3, sensed=False, order=(1, 2), path_length_m=1.0)))
    assert tally.arrived == set()


@pytest.mark.parametrize(("epoch", "heard"), [(0, 0), (2, 1), (4, 0)])
def test_an_announcement_of_another_epoch_is_void(epoch: int, heard: int) -> None:
    here, there = (Pose(x_m=x_m, y_m=0.0, heading_rad=0.0) for x_m in (0.0, 1.0))
    lining, driver = Lining(1, under(Law.CERTIFIED, robots=2), epoch=2), Driver(speed_mps=0.3)
    driver.hear(Odometry(t_s=0.0, pose=here, moving=False, finished=0, phase=Phase.RUNNING))
    lining.act(driver, None, 0.0)
    lining.hear(2, Muster(number=9, epoch=epoch, pose=there), 0.1)
    assert len(lining.beside()) == heard


def test_orders_in_an_epoch_without_its_dissolution_entry_break_s3() -> None:
    rehearsal = rehearsed(*queue(3, 0.8), closing(4.0))
    unsaid = [line for line in rehearsal.entries if not isinstance(line[1].record, StrandDissolved)]
    why = {breach.broken.why for breach in judge(rehearsal.world.scenario, unsaid).breaches}
    assert "ordered in epoch 2 without a strand" in why


def test_the_orders_of_one_epoch_end_before_those_of_the_next_begin() -> None:
    rehearsal = rehearsed(*queue(3, 0.8), closing(4.0), seed=4, plan=LOSSY)
    orders = [entry.record for _, entry in rehearsal.entries if isinstance(entry.record, OrderAccepted)]
    drives = [order.epoch for order in orders if order.target is not None]
    assert drives == sorted(drives)
    assert set(drives) >= {1, 2, 3}


actions = st.lists(
    st.one_of(
        st.tuples(st.just("round"), st.integers(0, 2**16), st.just(0.0)),
        st.tuples(st.just("live"), st.sampled_from(ORDER), st.floats(0.0, 1.0)),
        st.tuples(st.just("deliver"), st.integers(0, 50), st.floats(0.0, 1.0)),
        st.tuples(st.just("step"), st.floats(0.1, 2.0), st.floats(-3.1, 3.1)),
    ),
    max_size=60,
)


def dissolve(stage: TurningStage) -> None:
    """The first robot has the strand dissolve, as soon as it stands."""
    first = ORDER[0]
    strand = stage.members[first].strand
    for _ in range(10):
        if stage.drivers[first].standing:
            break
        stage.drivers[first].stand()
        stage.live(first, 0.5)
    strand.dissolution = Dissolution(times=1, seen=b"")


@given(actions, actions)
@settings(max_examples=50)
def test_no_robot_moves_any_more_when_the_tail_may_start_the_next_lining_up(
    before: list[tuple[str, float, float]], after: list[tuple[str, float, float]]
) -> None:
    stage = TurningStage(0.4)
    for action in before:
        stage.act(*action)
    dissolve(stage)
    places = None
    for action in [*after, *(("round", float(seed), 0.0) for seed in range(60)), *after]:
        if action[0] != "step":  # the leader has stopped for good
            stage.act(*action)
        if stage.members[ORDER[-1]].dissolves:
            now = {robot: (body.x_m, body.y_m) for robot, body in stage.bodies.items()}
            places = places or now
            assert now == places
            assert all(member.dissolves for member in stage.members.values())
    assert places is not None
