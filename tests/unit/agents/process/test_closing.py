"""How a robot's process tells its last entries, over a recorder that is played by the test."""

from collections.abc import Collection, Sequence
from functools import reduce
from pathlib import Path

import pytest

from agents.process.shell import Shell
from agents.process.victim import Victim
from protocol.errors import SessionLostError
from protocol.exit_codes import ExitCode
from protocol.frames import ROBOTS_MAX
from protocol.network.faulty_transport import Conditions
from protocol.network.session import Session
from protocol.network.traffic import Traffic, joined
from protocol.network.transport import Arrival, Heard
from protocol.timeline import Record, TrafficCounted
from protocol.wire.codec import encode
from protocol.wire.messages import LogBatch, Logged, Message, Phase

SESSION = Session(fleet="f", run="t", name="r1", robots=ROBOTS_MAX, endpoints=("tcp/127.0.0.1:1",))
KEYS = SESSION.keys


class PlayedRecorder:
    """A network behind which a recorder acknowledges all that fits into a message."""

    router: str | None = "a"

    def __init__(self) -> None:
        self.traffic = Traffic()
        self.records: list[Record] = []

    def put(self, key: str, message: Message) -> None:
        encode(message, 1, key)
        if isinstance(message, LogBatch):
            self.records += [entry.record for entry in message.entries]

    def ask(self, key: str, message: Message) -> None:
        raise NotImplementedError

    def watch(self, patterns: Collection[str]) -> None:
        raise NotImplementedError

    def timestamp(self) -> str:
        return ""

    async def arrivals(self, _: float | None) -> Sequence[Arrival]:
        return [Heard(KEYS.logged("r1"), 1, Logged(incarnation="a", up_to=len(self.records)))]


class SilentWorld(PlayedRecorder):
    """A network in which nobody answers."""

    async def arrivals(self, _: float | None) -> Sequence[Arrival]:
        return []


@pytest.mark.parametrize(
    ("phase", "limit", "reason"),
    [
        (Phase.OVER, "WORLD_SILENCE_S", "the world has been silent for -1 s"),
        (Phase.CLOSING, "CLOSING_PATIENCE_S", "the world has not recorded the last 2 timeline entries"),
    ],
)
async def test_a_robot_that_gives_its_world_up_says_why(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, phase: Phase, limit: str, reason: str
) -> None:
    monkeypatch.setattr(f"agents.process.shell.{limit}", -1.0)
    conditions = Conditions()
    victim = Victim(1, tmp_path, conditions, again=False)
    shell = Shell(1, SESSION, SilentWorld(), "a", conditions=conditions, victim=victim)
    shell._phase = phase
    with pytest.raises(SessionLostError, match=reason):
        await shell._close()


async def test_a_robot_that_has_talked_to_the_largest_fleet_tells_all_its_counts(tmp_path: Path) -> None:
    recorder, conditions = PlayedRecorder(), Conditions()
    for robot in range(2, ROBOTS_MAX + 1):
        recorder.traffic.send(KEYS.view("r1", f"r{robot}"))
        recorder.traffic.receive(KEYS.view(f"r{robot}", "r1"), 1)
    victim = Victim(1, tmp_path, conditions, again=False)
    shell = Shell(1, SESSION, recorder, "a", conditions=conditions, victim=victim)
    assert await shell._close() is ExitCode.OK
    counted = reduce(joined, [each for each in recorder.records if isinstance(each, TrafficCounted)])
    assert len(counted.sent) == len(counted.received) == ROBOTS_MAX - 1
