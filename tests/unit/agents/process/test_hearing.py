"""Which message on which key is which event for a robot's core."""

import pytest

from agents.events import Event, LinkHeard, OdometryHeard, ScanHeard, ViewHeard
from agents.process.hearing import event_for
from protocol.fence import Epoch, Fence
from protocol.frames import Pose
from protocol.network.transport import Heard
from protocol.wire.messages import BehindState, Logged, Message, Odometry, Phase, Scan
from protocol.wire.view import Plea

POSE, FENCE = Pose(x_m=0.0, y_m=0.0, heading_rad=0.0), Fence()
STATE = BehindState(
    epoch=Epoch(), life=1, t_s=0.0, vertices=1, progress_m=0.0, tail_progress_m=0.0, stand=True
)
ODOMETRY = Odometry(n=1, t_s=2.0, pose=POSE, moving=False, finished=0, fence=FENCE, phase=Phase.RUNNING)
SCAN = Scan(t_s=2.0, pose=POSE, fence=FENCE, ranges_m=(1.0,) * 8)
PLEA = Plea(epoch=Epoch(), life=1)
EVENTS: dict[str, tuple[Message, Event]] = {
    "link/r4/r3": (STATE, LinkHeard(4, 7, STATE)),
    "view/r4/r3": (PLEA, ViewHeard(4, 7, PLEA)),
    "body/r3/odometry": (ODOMETRY, OdometryHeard(ODOMETRY)),
    "body/r3/scan": (SCAN, ScanHeard(SCAN)),
}


@pytest.mark.parametrize("key", EVENTS)
def test_each_kind_of_message_on_its_key_is_an_event_with_its_sender_and_number(key: str) -> None:
    message, event = EVENTS[key]
    assert event_for("r3", key, Heard(key, 7, message), 2.0) == event


@pytest.mark.parametrize(
    "key",
    [
        "link/world/r3",
        "view/x/r3",
        "body/r4/odometry",
        "body/r4/scan",
        "body/r3/drive",
        "link/r4",
        "link/r4/r3/r2",
        "logged/r3",
        "",
    ],
)
@pytest.mark.parametrize(
    "message", [STATE, PLEA, ODOMETRY, SCAN, Logged(up_to=1)], ids=lambda each: type(each).__name__
)
def test_on_a_key_of_something_else_no_message_is_an_event(key: str, message: Message) -> None:
    assert event_for("r3", key, Heard(key, 7, message), 2.0) is None


@pytest.mark.parametrize("key", EVENTS)
def test_a_message_of_another_kind_than_its_key_is_no_event(key: str) -> None:
    for other, (message, _) in EVENTS.items():
        if other != key:
            assert event_for("r3", key, Heard(key, 7, message), 2.0) is None


def test_odometry_that_is_not_the_newest_is_no_event() -> None:
    assert event_for("r3", "body/r3/odometry", Heard("", 7, ODOMETRY), 2.1) is None
