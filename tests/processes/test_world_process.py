"""`python -m world` over a real router, against a robot played by the test."""

import json
import signal
import subprocess
import time
from collections import Counter
from collections.abc import Callable, Iterator, Sequence
from pathlib import Path
from typing import Any

import pytest

from protocol.faults.plan import NO_FAULTS
from protocol.fence import Bearing, Cause, Epoch, Fence, May, Raise, Turn
from protocol.frames import Point
from protocol.mission import Mission
from protocol.network.outbox import Outbox
from protocol.network.transport import Heard
from protocol.network.zenoh_transport import ZenohTransport
from protocol.process.asked import EXIT_CODES
from protocol.run_settings import SCENARIO_FILE, SETTINGS_FILE, Settings
from protocol.timeline import (
    GoalReached,
    Record,
    RobotArrived,
    RobotSettled,
    RouteLost,
    StrandJoined,
    TrafficCounted,
)
from protocol.wire.messages import Ask, Drive, Logged, Message, Odometry, Phase, Scan, ScanQuery
from tests.support.deadline import DEADLINE_S
from tests.support.processes.wire import (
    KEYS,
    TOKEN,
    arrivals_until,
    python,
    robot_transport,
    router,
    session_folder,
)
from tests.support.scenes.placed import circle, placed
from tests.support.stages.world_stage import formed, life_of, planned
from world.judge.verdict import VERDICT_FILE
from world.record.recorder import EVENTS_FILE
from world.record.run_files import prepare_folder

SCENARIO = placed(
    "one",
    [(0.0, 0.0)],
    (),
    circle((1.0, 1.0), 0.3),
    fleet={"separation_m": 0.1},
    goal=None,
    sensor={"range_m_max": 3.0},
    time={"time_s_max": 30.0},
)
TARGET = Point(x_m=0.5, y_m=0.0)


def behind_root(counts: dict[str, int]) -> dict[str, int]:
    return {KEYS.behind_root(key): count for key, count in counts.items()}


class Player:
    """Plays robot 1 with the minimum that docs/run.md asks of a robot."""

    def __init__(self, transport: ZenohTransport) -> None:
        self.transport = transport
        self.outbox = Outbox(TOKEN, resend_s=0.0)  # resend at once: tests need not wait
        self.now_s = 0.0
        self.number = 0
        self.fence = Fence()

    async def hear(self, wanted: Callable[[Message], bool]) -> Message:
        """Answer odometry and repeat the log until this message arrives."""
        while True:
            for arrival in await arrivals_until(self.transport, bool):
                match arrival:
                    case Heard(message=Odometry() as odometry):
                        self.now_s, self.fence = odometry.t_s, odometry.fence
                        if odometry.phase is Phase.RUNNING:
                            self.drive()
                    case Heard(message=Logged() as logged):
                        self.outbox.acknowledged(logged)
                    case _:
                        pass
                self.flush()
                if isinstance(arrival, Heard) and wanted(arrival.message):
                    return arrival.message

    def drive(self) -> None:
        target = TARGET if self.number else None
        order = Drive(
            number=self.number,
            basis_s=self.now_s,
            target=target,
            speed_mps=0.5,
            bearing=Bearing(epoch=self.fence.epoch, turn=self.fence.turn, life=life_of(1)),
            step=self.number,
            reach_m=0.5 * self.number,
        )
        self.transport.put(KEYS.drive("r1"), order)

    def note(self, *records: Record) -> None:
        for record in records:
            self.outbox.add(record, t_s=self.now_s, hlc=self.transport.timestamp())

    def flush(self) -> None:
        if len(self.outbox) and (batch := self.outbox.batch(time.monotonic())) is not None:
            self.transport.put(KEYS.log("r1"), batch)

    async def live(self) -> None:
        """Drive to the target and end the run properly."""
        await self.hear(is_in(Phase.RUNNING))
        epoch = Epoch().next(1, life_of(1))
        self.transport.put(KEYS.fence("r1"), Raise(epoch=epoch, cause=Cause.START))
        await self.hear(is_under(epoch, May.NOBODY))
        self.note(formed((1,), (Point(x_m=0.0, y_m=0.0),)))
        drives = Fence(epoch=epoch, turn=1, may=May.ALL, robot=1, members=1)
        self.transport.put(KEYS.fence("r1"), Turn(fence=drives))
        await self.hear(is_under(epoch, May.ALL))
        self.note(StrandJoined(epoch=epoch.number, rank=0, members=1))
        self.transport.ask(KEYS.scan("r1"), ScanQuery(revolutions=1))
        await self.hear(lambda message: isinstance(message, Scan))
        self.note(planned(TARGET, reach_m=0.5))
        self.number = 1
        await self.hear(lambda message: isinstance(message, Odometry) and message.finished == 1)
        self.note(GoalReached(x_m=0.5, y_m=0.0), RobotArrived(progress_m=0.5))
        await self.hear(is_in(Phase.OVER))
        await self.leave()

    async def leave(self) -> None:
        """The last messages of a robot that knows that the run is over."""
        traffic = self.transport.traffic
        self.note(RobotSettled(sent=behind_root(traffic.sent)))
        self.flush()
        await self.hear(is_in(Phase.CLOSING))
        sent, received, newest = map(behind_root, (traffic.sent, traffic.received, traffic.newest))
        self.note(
            TrafficCounted(
                sent=sent, received=received, newest=newest, refused={}, overflowed=0, unrecorded=0
            )
        )
        self.flush()
        await self.hear(lambda _: len(self.outbox) == 0)


def is_in(phase: Phase) -> Callable[[Message], bool]:
    return lambda message: isinstance(message, Odometry) and message.phase is phase


def is_under(epoch: Epoch, may: May) -> Callable[[Message], bool]:
    return lambda message: (
        isinstance(message, Odometry) and (message.fence.epoch, message.fence.may) == (epoch, may)
    )


@pytest.fixture
def folder() -> Iterator[Path]:
    with session_folder() as folder, router(folder):
        yield folder


def world_arguments(folder: Path, *options: str, speed: float | None = 1.0) -> Sequence[str]:
    run = folder / "run"
    run.mkdir()
    prepare_folder(run, SCENARIO, NO_FAULTS, Settings(seed=1, speed=speed))
    return ["-m", "world", str(run), "--session", str(folder / "world.json"), *options]


def end(world: subprocess.Popen[str]) -> str:
    """Wait until the world ends; returns its stderr."""
    return world.communicate(timeout=DEADLINE_S)[1]


def verdict(folder: Path) -> dict[str, Any]:
    said: dict[str, Any] = json.loads((folder / "run" / VERDICT_FILE).read_text())
    return said


def kinds(folder: Path) -> Counter[str]:
    return Counter(
        json.loads(line)["kind"] for line in (folder / "run" / EVENTS_FILE).read_text().splitlines()
    )


@pytest.mark.parametrize("speed", [1.0, 5.0, None])
async def test_a_run_goes_from_mission_to_verdict_and_every_message_is_accounted_for(
    folder: Path, speed: float | None
) -> None:
    with (
        python(*world_arguments(folder, speed=speed)) as world,
        robot_transport(folder, "r1") as transport,
    ):
        await Player(transport).live()
        said = end(world)
    assert world.returncode == 0, said
    passed = verdict(folder)
    assert (passed["ok"], passed["reason"]) == (True, "every living robot has arrived")
    assert passed["events"]["missing"] == 0
    assert (passed["messages"]["unaccounted"], passed["messages"]["left_out"]) == (0, [])
    assert passed["messages"]["received"] > 10
    assert passed["path_m"] == pytest.approx(0.5)
    recorded = kinds(folder)
    assert next(iter(recorded)) == "run.started"
    assert (recorded["order.accepted"], recorded["order.finished"], recorded["run.ended"]) == (1, 1, 1)


async def test_entries_of_a_process_whose_token_was_never_seen_are_not_recorded(folder: Path) -> None:
    with python(*world_arguments(folder)) as world:
        with robot_transport(folder, "r1") as transport:
            player, other = Player(transport), Player(transport)
            other.outbox = Outbox("forged", resend_s=0.0)
            await player.hear(is_in(Phase.RUNNING))
            other.note(RouteLost(reason="forged"))
            other.flush()
            await player.live()
        end(world)
    assert world.returncode == 0
    assert kinds(folder)["route.lost"] == 0


async def test_queries_for_mission_and_scans_are_answered(folder: Path) -> None:
    with python(*world_arguments(folder)) as world:
        with robot_transport(folder, "r1") as transport:
            player = Player(transport)
            await player.hear(is_in(Phase.RUNNING))
            transport.ask(KEYS.mission(), Ask())
            mission = await player.hear(lambda message: isinstance(message, Mission))
            assert isinstance(mission, Mission)
            assert (mission.robots, mission.robot_radius_m) == (1, 0.1)
            transport.ask(KEYS.scan("r1"), ScanQuery(revolutions=1))
            scan = await player.hear(lambda message: isinstance(message, Scan))
            assert isinstance(scan, Scan)
            assert min(scan.ranges_m) == pytest.approx(2**0.5 - 0.3, abs=1e-3)
            world.send_signal(signal.SIGINT)
            await player.hear(is_in(Phase.OVER))
            await player.leave()
        end(world)
    assert world.returncode == 130
    assert verdict(folder)["reason"] == "the run was interrupted"


@pytest.mark.parametrize(("number", "code"), EXIT_CODES.items())
async def test_the_verdict_has_the_code_of_the_signal_that_ended_the_world(
    folder: Path, number: signal.Signals, code: int
) -> None:
    with python(*world_arguments(folder)) as world:
        with robot_transport(folder, "r1") as transport:
            player = Player(transport)
            await player.hear(is_in(Phase.RUNNING))
            world.send_signal(number)
            await player.hear(is_in(Phase.OVER))
            await player.leave()
        end(world)
    assert (world.returncode, verdict(folder)["exit_code"]) == (code, code)


async def test_a_robot_that_vanishes_without_goodbye_counts_as_dead_and_the_run_fails(folder: Path) -> None:
    with python(*world_arguments(folder, speed=None)) as world:
        with robot_transport(folder, "r1") as transport:
            player = Player(transport)
            await player.hear(lambda message: isinstance(message, Odometry) and message.t_s > 1.0)
        said = end(world)
    assert world.returncode == 1, said
    passed = verdict(folder)
    assert passed["reason"].startswith("robot 1 died at t=")
    assert [death["robot"] for death in passed["deaths"]] == [1]


def test_the_world_ends_with_its_lifeline_and_writes_a_verdict(folder: Path) -> None:
    with python(*world_arguments(folder, "--lifeline")) as world:
        assert world.stdin is not None
        world.stdin.close()
        world.wait(timeout=DEADLINE_S)
    assert world.returncode == 143
    assert verdict(folder)["ok"] is False


FULL_DISK = """
import resource, sys
sys.dont_write_bytecode = True  # of what is loaded later, half would be kept
from world.__main__ import main
resource.setrlimit(resource.RLIMIT_FSIZE, (4000, 4000))
sys.exit(main())
"""


async def test_a_full_disk_ends_the_run_in_one_line(folder: Path) -> None:
    _, _, *arguments = world_arguments(folder)
    with python("-c", FULL_DISK, *arguments) as world, robot_transport(folder, "r1") as transport:
        player = Player(transport)
        await player.hear(is_in(Phase.RUNNING))
        player.note(*[RobotArrived(progress_m=0.0)] * 100)
        player.flush()
        said = end(world)
    assert world.returncode == 1
    assert said.splitlines()[-1].startswith("world: cannot write")
    assert said.splitlines()[-1].endswith("events.jsonl': File too large")
    assert "Traceback" not in said


USAGE = {
    "no run": ("", [], "no run has been prepared there: it has no run.toml"),
    "no scenario": ("seed = 1", [], "scenario.toml: cannot be read"),
    "no such speed": ("seed = 1\nspeed = -1.0", [], "$.speed"),
    "no such session": ("seed = 1", ["--session", "/nowhere/world.json"], "no session in /nowhere"),
}


@pytest.mark.parametrize(("settings", "options", "complaint"), USAGE.values(), ids=USAGE.keys())
def test_impossible_settings_are_refused_in_one_line_and_leave_nothing(
    folder: Path, settings: str, options: list[str], complaint: str
) -> None:
    run = folder / "run"
    arguments = world_arguments(folder, *options)
    (run / SETTINGS_FILE).write_text(settings)
    if not settings:
        (run / SETTINGS_FILE).unlink()
    if "scenario" in complaint:
        (run / SCENARIO_FILE).unlink()
    before = sorted(run.iterdir())
    with python(*arguments) as world:
        said = end(world)
    assert world.returncode == 2
    assert complaint in said.splitlines()[-1]
    assert sorted(run.iterdir()) == before


async def test_a_restarted_world_refuses_a_scenario_that_was_changed_meanwhile(folder: Path) -> None:
    arguments = world_arguments(folder, "--resume")
    with python(*arguments) as world, robot_transport(folder, "r1") as transport:
        await Player(transport).hear(is_in(Phase.RUNNING))
        world.kill()
        end(world)
    kept = folder / "run" / SCENARIO_FILE
    kept.write_text(kept.read_text().replace("radius_m = 0.3", "radius_m = 0.4"))
    with python(*arguments) as world:
        said = end(world)
    assert world.returncode == 2
    assert said.splitlines()[-1].endswith("scenario.toml: was changed after the run had begun")


async def test_a_second_world_does_not_resume_a_run_that_goes_on(folder: Path) -> None:
    arguments = world_arguments(folder, "--resume")
    with python(*arguments) as world, robot_transport(folder, "r1") as transport:
        player = Player(transport)
        await player.hear(is_in(Phase.RUNNING))
        with python(*arguments) as second:
            said = end(second)
        assert second.returncode == 2
        assert said.splitlines()[-1].endswith("events.jsonl: another world writes it")
        await player.live()
        said = end(world)
    assert world.returncode == 0, said


def test_a_world_of_several_fleets_is_not_resumed(folder: Path) -> None:
    session = ["--session", str(folder / "world.json")]
    with python(*world_arguments(folder, *session, "--resume")) as world:
        said = end(world)
    assert world.returncode == 2
    assert said == "world: --resume: the clocks of several fleets would go on from different times\n"
