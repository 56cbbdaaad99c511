"""Messages, entries and events are in no reference cycle, so the collector does not search them."""

from typing import get_args

import pytest

from agents.commands import Command as RobotCommand
from agents.events import Event as RobotEvent
from protocol.timeline import Entry, Record
from protocol.wire.messages import AheadState, BehindState, Drive, Odometry, Scan
from protocol.wire.view import ViewMessage
from world.commands import Command as WorldCommand
from world.events import Event as WorldEvent

EVERY_TICK = (AheadState, BehindState, Drive, Entry, Odometry, Scan)
UNIONS = (Record, ViewMessage, RobotEvent, RobotCommand, WorldEvent, WorldCommand)
ALL = {*EVERY_TICK, *(kind for union in UNIONS for kind in get_args(union))}


@pytest.mark.parametrize("kind", sorted(ALL, key=str), ids=lambda kind: f"{kind.__module__}.{kind.__name__}")
def test_the_collector_does_not_search(kind: type) -> None:
    assert kind.__struct_config__.gc is False  # type: ignore[attr-defined]  # of a Struct
