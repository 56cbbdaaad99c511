"""What is read from a timeline while it is written, and what counts as an aim that was missed."""

from pathlib import Path

import pytest
from msgspec.structs import replace

from clew.bench.progress import NTP64_PER_S, Progress, Together
from clew.bench.scale import ScaleRun, figures, ground_of, queue_before_posts, scale_run, spell
from clew.bench.usage import ROBOTS_ASKED_MAX, Process, Usage, cpu_s, processes, sample
from protocol.timeline import Entry, PoseSampled, Record, RobotSettled, StrandJoined
from tests.support.campaigns import clew
from tests.support.logs.logs import GOOD
from world.judge.verdict import Late
from world.record.recorder import line
from world.scenario.fleets import SharedGround

PLACED = PoseSampled(robot=1, x_m=0.0, y_m=0.0, heading_rad=0.0, clearance_m=None, separation_m=1.0)
JOINED = StrandJoined(epoch=10001, rank=0, members=2)
USED = Usage(processes=2, pss_mb=4.0, files=20.0)


def written(t_s: float, wall_s: float, record: Record, source: str = "world") -> bytes:
    return line(source, Entry(n=1, t_s=t_s, hlc=f"{int(wall_s * NTP64_PER_S)}/1", record=record))


def formed() -> Progress:
    progress = Progress(2)
    timeline = written(0.0, 102.0, PLACED) + b"".join(
        written(0.5, 104.0 + robot, JOINED, f"r{robot}") for robot in (1, 2)
    )
    for at in range(0, len(timeline), 7):
        progress.read(timeline[at : at + 7])
    return progress


def run(progress: Progress, **changed: object) -> ScaleRun:
    driving = spell({"robot": 3.0}, robots=2, sim_s=10.0, wall_s=11.0, used={"robot": USED})
    verdict = replace(GOOD, ticks_late=Late(p50_s=0.001, p99_s=0.01), wall_s=2.0)
    told = scale_run(
        [verdict],
        Together([progress]),
        robots=2,
        speed=1.0,
        began_s=100.0,
        said="",
        standing=driving,
        driving=driving,
        load=(0.0, 1.0),
    )
    return replace(told, **changed)


def test_a_fleet_is_ready_when_bodies_are_placed_and_formed_when_the_last_has_joined() -> None:
    told = run(formed())
    assert (told.ready_s, told.formed_s, told.formed_sim_s) == pytest.approx((2.0, 6.0, 0.5))


def test_a_run_is_over_when_robots_settle() -> None:
    progress = formed()
    assert not progress.is_over
    progress.read(written(9.0, 110.0, RobotSettled(sent={}), "r1"))
    assert (progress.is_over, progress.now_s) == (True, 9.0)


def test_processor_time_is_per_robot_and_simulated_second() -> None:
    assert spell({"robot": 3.0}, robots=2, sim_s=10.0, wall_s=60.0, used={}).cpu_ms_in_all == 150.0


def test_only_processes_that_were_there_before_count() -> None:
    before = [
        Process(pid=1, part="robot", cpu_s=1.0, files=3),
        Process(pid=2, part="world", cpu_s=1.0, files=3),
    ]
    after = [
        Process(pid=1, part="robot", cpu_s=1.5, files=3),
        Process(pid=9, part="robot", cpu_s=7.0, files=3),
    ]
    assert cpu_s(before, after) == {"robot": 0.5}


@pytest.mark.parametrize("robots", [1, 39, 41, 200, 1000])
def test_memory_is_asked_of_some_robots_of_every_rank(robots: int) -> None:
    fleet = [Process(pid=pid, part="robot", cpu_s=0.0, files=3) for pid in range(robots)]
    asked = [each.pid for each in sample(fleet)]
    assert len(set(asked)) == len(asked) <= 2 * ROBOTS_ASKED_MAX
    assert robots < 200 or {pid % 5 for pid in asked} == set(range(5)), "the first of five leads"


def test_a_process_that_has_gone_is_left_out() -> None:
    assert processes({2**22 + 1: "python -m world"}) == []


def missed(*runs: ScaleRun) -> list[str]:
    return [each.name for each in figures(runs) if each.met is False]


@pytest.mark.parametrize(
    ("changed", "names"),
    [
        ({}, []),
        ({"ready_s": 5.1}, ["2 robots: ready"]),
        ({"formed_s": None}, ["2 robots: formed"]),
        ({"ok": False}, ["2 robots: verdict ok"]),
        ({"ticks_late": Late(p50_s=0.0, p99_s=0.06)}, ["2 robots: ticks late, p99"]),
        ({"driving": None}, ["2 robots: memory of a robot, driving"]),
    ],
)
def test_an_aim_that_was_missed_is_named(changed: dict[str, object], names: list[str]) -> None:
    assert missed(run(formed(), **changed)) == names


def test_a_robot_of_a_large_fleet_may_cost_little_more_than_one_of_fifty() -> None:
    few = run(formed(), robots=50)
    dear = spell({"robot": 4.0}, robots=2, sim_s=10.0, wall_s=11.0, used={"robot": USED})
    assert missed(few, run(formed(), robots=200)) == []
    assert missed(few, run(formed(), robots=200, driving=dear)) == [
        "200 robots: CPU time for a robot, driving"
    ]


def test_runs_of_one_size_are_repeats() -> None:
    told = {each.name: each for each in figures([run(formed()), run(formed(), ready_s=4.0)])}
    assert told["2 robots: ready"].measured.repeats == 2


def test_the_queue_has_posts_before_it_and_none_beside_it() -> None:
    scenario = queue_before_posts(50, seed=1)
    first = scenario.fleet.start
    assert first is not None
    posts = [each.centre_m for each in scenario.obstacles if hasattr(each, "centre_m")]
    assert posts
    assert all(x_m > first[0] for x_m, _ in posts)


def test_a_run_that_was_told_to_end_is_good_if_it_kept_its_promises_until_then() -> None:
    told = run(formed(), ok=False, is_cut_short=True)
    assert told.is_good
    assert figures([told])[-1].name == "2 robots: no promise broken, nobody declared dead"
    assert not replace(told, violations=1).is_good
    assert not replace(told, deaths=1).is_good
    assert not replace(told, is_cut_short=False).is_good


def test_several_strands_are_ready_and_formed_with_the_last_of_them() -> None:
    late = Progress(2)
    together = Together([formed(), late])
    assert (together.ready_at_s, together.has_formed(), together.formed_at_s) == (None, False, None)
    late.read(written(0.0, 103.0, PLACED))
    late.read(written(0.7, 109.0, JOINED, "r1") + written(0.8, 110.0, JOINED, "r2"))
    assert together.has_formed()
    assert not together.has_formed(times=2)
    told = (together.ready_at_s, together.formed_at_s, together.formed_s, together.now_s)
    assert told == pytest.approx((103.0, 110.0, 0.8, 0.5))


def test_a_contact_of_two_strands_and_a_verdict_that_lacks_are_failures() -> None:
    def told(strands: int, contacts: int = 0) -> ScaleRun:
        return scale_run(
            [GOOD, GOOD],
            Together([formed(), formed()]),
            robots=4,
            strands=strands,
            contacts=contacts,
            speed=1.0,
            began_s=100.0,
            said="the world was killed",
            standing=None,
            driving=None,
            load=(0.0, 1.0),
        )

    assert (told(2).ok, told(2).violations, told(2).reason) == (True, 0, GOOD.reason)
    assert (told(2, contacts=1).ok, told(2, contacts=1).violations) == (False, 1)
    assert (told(3).ok, told(3).reason) == (False, "the world was killed")


def test_strands_stand_beside_each_other_each_before_posts_of_its_own() -> None:
    ground = ground_of(200, 40, seed=1)
    assert isinstance(ground, SharedGround)
    scenarios = ground.scenarios()
    assert len(scenarios) == 40
    assert {each.fleet.robots for each in scenarios.values()} == {5}
    lanes = {round(each.fleet.poses()[0].y_m / 3.0 - 0.5, 9) for each in scenarios.values()}
    assert lanes == set(range(40))


@pytest.mark.parametrize("bench", [("scale", "-n", "2"), ("soak", "-n", "2")])
def test_runs_cannot_be_kept_where_no_folder_can_be(tmp_path: Path, bench: tuple[str, ...]) -> None:
    (tmp_path / "file").touch()
    said = clew("bench", *bench, "--keep", tmp_path / "file")
    assert said.exit_code == 2
    last = said.stderr.splitlines()[-1]
    assert last.startswith(f"Error: cannot keep a run in {tmp_path}/file/")
    assert last.endswith(": Not a directory")
