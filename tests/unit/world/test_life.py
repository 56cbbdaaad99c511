"""The shell of the world of one fleet, over a transport that is played by the test."""

import asyncio
import contextlib
import time
from collections.abc import Callable, Collection, Iterator, Sequence
from pathlib import Path

import pytest

from protocol.errors import UsageError
from protocol.faults.plan import NO_FAULTS
from protocol.network.session import Session
from protocol.network.traffic import Traffic
from protocol.network.transport import Arrival, Asked
from protocol.process.tokens import TokenCame
from protocol.wire.messages import Ask, Faults, Message
from world.faults import RunFaults
from world.life import TAKE_WALL_S, Life, Request
from world.record.readback import Readback
from world.record.recorder import Recorder, open_events
from world.record.run_files import header_of
from world.scenario.scenario import load
from world.shell import _arrived

QUESTIONS = 30
ANSWER_S = 0.01  # as a scan of many revolutions


class Flooded:
    """A transport with so many questions at once that to answer them takes longer than a turn may."""

    def __init__(self, session: Session) -> None:
        self.traffic = Traffic()
        self.router: str | None = "router"
        self.answered: list[int] = []
        self._key = session.keys.mission()

    async def arrivals(self, _: float | None) -> Sequence[Arrival]:
        return [Asked(self._key, Ask(), self._answer(number)) for number in range(QUESTIONS)]

    def put(self, key: str, message: Message) -> None:
        pass

    def ask(self, key: str, message: Message) -> None:
        pass

    def watch(self, patterns: Collection[str]) -> None:
        pass

    def timestamp(self) -> str:
        return ""

    def _answer(self, number: int) -> Callable[[Message], None]:
        def answer(_: Message) -> None:
            time.sleep(ANSWER_S)
            self.answered.append(number)

        return answer


@contextlib.contextmanager
def life_over(transport: Flooded, session: Session, folder: Path) -> Iterator[Life]:
    scenario = load("grove")
    header = header_of(scenario, NO_FAULTS, run="run", seed=1, speed=1.0, started_at="", hlc="")
    request = Request(
        scenario=scenario, session=session, out=folder, seed=1, speed=1.0, lifeline=None, private=folder
    )
    with open_events(folder) as file, contextlib.closing(Readback(folder, file)) as readback:
        yield Life(
            request,
            transport,
            Recorder(file, header),
            readback,
            "",
            faults=RunFaults(NO_FAULTS, 1, robots=scenario.fleet.robots),
            past=None,
        )


async def test_a_turn_takes_messages_for_a_limited_time_and_the_rest_in_order_in_later_turns(
    tmp_path: Path,
) -> None:
    session = Session(fleet="clew", run="run", name="world", endpoints=("tcp/127.0.0.1:1",))
    transport = Flooded(session)
    with life_over(transport, session, tmp_path) as life:
        life.turn(await _arrived(life, 1.0), None)
        assert len(transport.answered) <= TAKE_WALL_S / ANSWER_S + 1
        while len(transport.answered) < QUESTIONS:
            assert await _arrived(life, 1.0) == ()  # it takes in no more before
            life.turn((), None)
        assert len(await _arrived(life, 1.0)) == QUESTIONS
    assert transport.answered == list(range(QUESTIONS))


def test_only_a_held_run_is_asked_to_go_on_since_another_one_would_be_held_by_that(tmp_path: Path) -> None:
    session = Session(fleet="clew", run="run", name="world", endpoints=("tcp/127.0.0.1:1",))

    async def ask() -> None:
        with life_over(Flooded(session), session, tmp_path) as life:
            life.go(1.0)

    with pytest.raises(UsageError, match="the run is not held"):
        asyncio.run(ask())


async def test_the_operator_is_told_what_the_fleet_is_now(tmp_path: Path) -> None:
    session = Session(fleet="clew", run="run", name="world", endpoints=("tcp/127.0.0.1:1",))
    with life_over(Flooded(session), session, tmp_path) as life:
        for robot in life._world.attendance.robots:
            life._handle(TokenCame(robot, "a"))
        life.turn((), None)
        assert life.halt(stop=True) == "stopped, epoch 10000"
        assert life.halt(stop=False) == "released, epoch 20000"


async def test_a_world_that_a_fault_slows_down_does_not_take_the_machine_for_late(tmp_path: Path) -> None:
    session = Session(fleet="clew", run="run", name="world", endpoints=("tcp/127.0.0.1:1",))
    with life_over(Flooded(session), session, tmp_path) as life:
        life._transport.have(Faults(number=1, step=0, struck=(), rules=(), slow_s=0.05))
        life.note_turn(1.0, asked_s=0.0)
        await life.arrivals(0.0)
        life.note_turn(1.05, asked_s=0.0)
        assert life._world.answers.lateness.now_s(1.05) == 0.0
