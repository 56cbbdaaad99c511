"""`python -m agents` over a real router, against a world played by the test."""

import argparse
import asyncio
import os
import signal
import subprocess
from collections import defaultdict
from collections.abc import AsyncIterator, Callable, Sequence
from contextlib import asynccontextmanager
from pathlib import Path

import pytest
from msgspec.structs import replace

from agents.__main__ import robots_of
from protocol.faults.process_commands import send_process_fault
from protocol.faults.process_faults import ProcessAction, ProcessFault
from protocol.fence import Fence
from protocol.frames import Pose
from protocol.keys import robot_name
from protocol.network.transport import Appeared, Arrival, Asked, Heard, Vanished
from protocol.network.zenoh_transport import ZenohTransport
from protocol.timeline import Record, RobotSettled, RobotStarted, TrafficCounted
from protocol.wire.messages import LogBatch, Logged, Odometry, Phase
from tests.support.deadline import DEADLINE_S
from tests.support.processes.fleets import wait_until
from tests.support.processes.wire import KEYS, python, router, session_folder, world_transport
from tests.support.stages.one_step import MISSION

THREE = ("r1", "r2", "r3")


class PlayedWorld:
    """Hands out the mission, acknowledges log entries, and keeps the entries and the vanished tokens."""

    def __init__(self, transport: ZenohTransport, private: Path) -> None:
        self._transport = transport
        self._private = private
        self.records: defaultdict[str, list[Record]] = defaultdict(list)
        self.gone: set[str] = set()

    async def until(self, done: Callable[[], bool]) -> None:
        """Play until the condition holds; fails after the deadline."""
        async with asyncio.timeout(DEADLINE_S):
            while not done():
                for arrival in await self._transport.arrivals(None):
                    self._take(arrival)

    async def until_recorded(self, kind: type[Record], names: Sequence[str] = THREE) -> None:
        """Play until each of these robots has recorded an entry of this kind."""
        await self.until(lambda: all(any(isinstance(r, kind) for r in self.records[name]) for name in names))

    def _take(self, arrival: Arrival) -> None:
        match arrival:
            case Asked(key, answer=answer) if key == KEYS.mission():
                answer(replace(MISSION, robots=3))
            case Heard(key, message=LogBatch(incarnation=incarnation, entries=entries)):
                name = KEYS.part(key, 1)
                self.records[name] += [entry.record for entry in entries]
                self._transport.put(KEYS.logged(name), Logged(incarnation=incarnation, up_to=entries[-1].n))
            case Vanished(key):
                self.gone.add(KEYS.part(key, 1))
            case Appeared(key):
                self.gone.discard(KEYS.part(key, 1))
            case _:
                pass

    def tell(self, t_s: float, phase: Phase, *names: str) -> None:
        """Send these robots, or all, the odometry of a standing body."""
        for name in names or THREE:
            pose = Pose(x_m=float(name[1]), y_m=0.0, heading_rad=0.0)
            odometry = Odometry(n=1, t_s=t_s, pose=pose, moving=False, finished=0, fence=Fence(), phase=phase)
            self._transport.put(KEYS.odometry(name), odometry)

    def strike(self, name: str, action: ProcessAction) -> None:
        """Have the host apply this process fault to a robot."""
        send_process_fault(self._private, ProcessFault("test", action, name), speed=1.0)

    def pid(self, name: str) -> int:
        """The process id that a robot reports."""
        return self.pids(name)[-1]

    def pids(self, name: str) -> list[int]:
        """The process ids of all processes that this robot has had."""
        return [record.pid for record in self.records[name] if isinstance(record, RobotStarted)]


PATIENT = """
import sys
from agents.__main__ import main
from agents.process import host
host.KILL_AFTER_S = 300.0  # on a busy machine a robot takes longer to end than a host waits for it
sys.exit(main())
"""


@asynccontextmanager
async def host(robots: str, *program: str) -> AsyncIterator[tuple[PlayedWorld, subprocess.Popen[str]]]:
    """A host whose robots have started, and the world that the test plays."""
    with session_folder() as folder, router(folder), world_transport(folder) as transport:
        world = PlayedWorld(transport, folder)
        options = ("--robots", robots, "--sessions", str(folder), "--lifeline")
        with python(*(program or ("-m", "agents")), *options) as process:
            await world.until_recorded(RobotStarted, [robot_name(robot) for robot in robots_of(robots)])
            yield world, process


def ended(process: subprocess.Popen[str]) -> tuple[int, str]:
    """A process's exit code and what it printed on stderr."""
    exit_code = process.wait(timeout=DEADLINE_S)
    assert process.stderr is not None
    return exit_code, process.stderr.read()


async def test_every_robot_is_a_separate_process_and_ends_when_the_run_is_closed() -> None:
    async with host("1-3") as (world, process):
        pids = {world.pid(name) for name in THREE}
        assert len(pids | {process.pid}) == 4
        world.tell(0.0, Phase.RUNNING)
        world.tell(0.1, Phase.OVER)
        await world.until_recorded(RobotSettled)
        world.tell(0.1, Phase.CLOSING)
        await world.until_recorded(TrafficCounted)
        assert ended(process) == (0, "")


async def test_a_killed_robot_is_named_and_the_others_continue() -> None:
    async with host("1-3") as (world, process):
        os.kill(world.pid("r2"), signal.SIGKILL)
        await world.until(lambda: "r2" in world.gone)
        world.tell(0.0, Phase.CLOSING)
        await world.until_recorded(TrafficCounted, ["r1", "r3"])
        assert ended(process) == (0, "robot 2 was ended by SIGKILL\n"), (
            "the run is over; its verdict names r2"
        )


async def test_a_host_all_of_whose_robots_die_fails_with_the_code_of_the_first() -> None:
    async with host("1-2") as (world, process):
        os.kill(world.pid("r2"), signal.SIGTERM)
        await world.until(lambda: "r2" in world.gone)
        until_reaped(world, "r2")
        os.kill(world.pid("r1"), signal.SIGKILL)
        said = "robot 2 was ended by SIGTERM\nrobot 1 was ended by SIGKILL\n"
        assert ended(process) == (143, said)


async def test_a_robot_killed_by_a_process_fault_is_no_failure_of_the_host() -> None:
    async with host("1-3") as (world, process):
        world.strike("r2", ProcessAction.KILL)
        await world.until(lambda: "r2" in world.gone)
        world.tell(0.0, Phase.CLOSING)
        await world.until_recorded(TrafficCounted, ["r1", "r3"])
        assert ended(process) == (0, "")


async def test_a_host_whose_last_robot_is_killed_when_the_run_is_over_waits_for_nobody() -> None:
    async with host("1-3") as (world, process):
        world.tell(0.0, Phase.CLOSING, "r1", "r3")
        await world.until_recorded(TrafficCounted, ["r1", "r3"])
        until_reaped(world, "r1", "r3")
        world.strike("r2", ProcessAction.KILL)
        assert ended(process) == (0, "")


async def test_a_robot_that_is_killed_and_restarted_is_a_new_process() -> None:
    async with host("1-3") as (world, process):
        world.strike("r2", ProcessAction.KILL)
        world.strike("r2", ProcessAction.START)
        await world.until(lambda: len(world.pids("r2")) == 2)
        assert len(set(world.pids("r2"))) == 2
        world.tell(0.0, Phase.CLOSING)
        await world.until_recorded(TrafficCounted)
        assert ended(process) == (0, "")


async def test_a_start_of_a_robot_that_is_alive_does_not_undo_its_later_kill() -> None:
    async with host("1-3") as (world, process):
        world.strike("r2", ProcessAction.START)
        world.strike("r2", ProcessAction.KILL)
        await world.until(lambda: "r2" in world.gone)
        until_reaped(world, "r2")
        world.tell(0.0, Phase.CLOSING, "r1", "r3")
        await world.until_recorded(TrafficCounted, ["r1", "r3"])
        assert ended(process) == (0, "")
        assert len(world.pids("r2")) == 1


async def test_a_robot_that_is_killed_started_and_frozen_at_once_starts_when_it_is_thawed() -> None:
    async with host("1-3") as (world, process):
        process.send_signal(signal.SIGSTOP)  # so it hears the next three together
        for action in (ProcessAction.KILL, ProcessAction.START, ProcessAction.FREEZE):
            world.strike("r2", action)
        process.send_signal(signal.SIGCONT)
        until_reaped(world, "r2")
        os.kill(world.pid("r1"), signal.SIGKILL)
        until_reaped(world, "r1")  # so the host has gone on after the end of r2
        assert children(process) == [world.pid("r3")]
        world.strike("r2", ProcessAction.THAW)
        await world.until(lambda: len(world.pids("r2")) == 2)
        world.tell(0.0, Phase.CLOSING, "r2", "r3")
        await world.until_recorded(TrafficCounted, ["r2", "r3"])
        assert ended(process) == (0, "robot 1 was ended by SIGKILL\n")


def children(process: subprocess.Popen[str]) -> list[int]:
    """The processes that a process has forked, and that it has not reaped."""
    return [int(pid) for pid in Path(f"/proc/{process.pid}/task/{process.pid}/children").read_text().split()]


def until_reaped(world: PlayedWorld, *names: str) -> None:
    """Wait until the host has reaped these robots."""
    wait_until(lambda: None if any(Path(f"/proc/{world.pid(name)}").exists() for name in names) else True)


def kill_all(world: PlayedWorld) -> None:
    """Have all robots killed, and wait until their host has reaped them."""
    for name in THREE:
        world.strike(name, ProcessAction.KILL)
    until_reaped(world, *THREE)


async def test_a_host_all_of_whose_robots_are_killed_can_be_told_to_start_them_again() -> None:
    async with host("1-3") as (world, process):
        kill_all(world)
        for name in THREE:
            world.strike(name, ProcessAction.START)
        await world.until(lambda: all(len(world.pids(name)) == 2 for name in THREE))
        world.tell(0.0, Phase.CLOSING)
        await world.until_recorded(TrafficCounted)
        assert ended(process) == (0, "")


async def test_a_host_all_of_whose_robots_are_killed_ends_at_once_when_it_is_asked_to() -> None:
    async with host("1-3", "-c", PATIENT) as (world, process):
        kill_all(world)
        process.terminate()
        assert ended(process) == (143, "")


ONE_AT_A_TIME = """
import sys, time
from pathlib import Path
from agents.__main__ import main
from agents.process import host, starting
starting.CONNECTING_MAX, tell = 1, host._Host._tell_connected
def tell_later(self):
    while not Path(sys.argv[4], "go").exists():
        time.sleep(0.01)
    tell(self)
host._Host._tell_connected = tell_later
sys.exit(main())
"""


@asynccontextmanager
async def second_struck_while_it_waits(
    action: ProcessAction,
) -> AsyncIterator[tuple[PlayedWorld, subprocess.Popen[str]]]:
    """A host that has started two of its three robots, since a fault struck the other before its start."""
    with session_folder() as folder, router(folder), world_transport(folder) as transport:
        world = PlayedWorld(transport, folder)
        options = ("--robots", "1-3", "--sessions", str(folder), "--lifeline")
        with python("-c", ONE_AT_A_TIME, *options) as process:
            wait_until(lambda: (folder / "h1.sock").exists() or None)
            world.strike("r2", action)
            (folder / "go").touch()
            await world.until_recorded(RobotStarted, ["r1", "r3"])
            assert world.pids("r2") == []
            yield world, process


async def test_a_robot_that_is_killed_while_it_waits_to_be_started_waits_for_a_start() -> None:
    async with second_struck_while_it_waits(ProcessAction.KILL) as (world, process):
        world.strike("r2", ProcessAction.START)
        await world.until_recorded(RobotStarted, ["r2"])
        world.tell(0.0, Phase.CLOSING)
        await world.until_recorded(TrafficCounted)
        assert ended(process) == (0, "")


async def test_a_robot_that_is_frozen_while_it_waits_to_be_started_starts_when_it_is_thawed() -> None:
    async with second_struck_while_it_waits(ProcessAction.FREEZE) as (world, process):
        world.strike("r2", ProcessAction.START)  # it is frozen, not dead
        for name in ("r1", "r3"):
            os.kill(world.pid(name), signal.SIGKILL)
            until_reaped(world, name)
        assert children(process) == []
        world.strike("r2", ProcessAction.THAW)
        await world.until_recorded(RobotStarted, ["r2"])
        world.tell(0.0, Phase.CLOSING, "r2")
        await world.until_recorded(TrafficCounted, ["r2"])
        assert ended(process) == (0, "robot 1 was ended by SIGKILL\nrobot 3 was ended by SIGKILL\n")


async def test_a_frozen_robot_shows_no_token_until_it_is_thawed() -> None:
    async with host("1-3") as (world, process):
        world.strike("r2", ProcessAction.FREEZE)
        await world.until(lambda: "r2" in world.gone)
        world.strike("r2", ProcessAction.THAW)
        await world.until(lambda: "r2" not in world.gone)
        world.tell(0.0, Phase.CLOSING)
        await world.until_recorded(TrafficCounted)
        assert ended(process) == (0, "")


async def test_a_host_that_is_asked_to_end_also_ends_a_frozen_robot() -> None:
    async with host("1-3", "-c", PATIENT) as (world, process):
        world.strike("r2", ProcessAction.FREEZE)
        await world.until(lambda: "r2" in world.gone)
        process.terminate()
        code, said = ended(process)
        assert code == 143
        assert "robot" not in said, "the host thawed it, so it ended on request and was not killed"


async def test_robots_do_not_outlive_a_host_that_is_killed() -> None:
    async with host("1-3") as (world, process):
        process.kill()
        await world.until(lambda: world.gone >= set(THREE))


@pytest.mark.parametrize("way", ["SIGTERM", "SIGINT", "SIGHUP", "lifeline"])
async def test_a_host_that_is_asked_to_end_ends_its_robots(way: str) -> None:
    async with host("1-3") as (world, process):
        if way == "lifeline":
            assert process.stdin is not None
            process.stdin.close()
        else:
            process.send_signal(signal.Signals[way])
        await world.until(lambda: world.gone >= set(THREE))
        expected = {"SIGINT": 130, "SIGHUP": 129}.get(way, 143)
        assert process.wait(timeout=DEADLINE_S) == expected


async def test_a_single_robot_needs_no_host() -> None:
    async with host("3") as (world, process):
        assert world.pid("r3") == process.pid


def test_a_missing_session_is_reported_in_one_line_with_exit_code_2(tmp_path: Path) -> None:
    with python("-m", "agents", "--robots", "3", "--sessions", str(tmp_path)) as process:
        exit_code, said = ended(process)
    assert exit_code == 2
    assert said.startswith("robot 3: no session in ")
    assert said.count("\n") == 1


@pytest.mark.parametrize(
    ("text", "robots"), [("3", [3]), ("1-5", [1, 2, 3, 4, 5]), ("1-3,7", [1, 2, 3, 7]), ("2000", [2000])]
)
def test_a_list_of_robots_is_read(text: str, robots: list[int]) -> None:
    assert robots_of(text) == robots


@pytest.mark.parametrize(
    "text", ["", "0", "5-1", "1,1", "a", "1-", "-3", "1-2-3", "5-3,7", "2001", "1-99999999999", "²"]
)
def test_a_text_that_is_no_list_of_robots_is_refused(text: str) -> None:
    with pytest.raises(argparse.ArgumentTypeError):
        robots_of(text)
