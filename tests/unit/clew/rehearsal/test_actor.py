"""The inbox of a robot that does not attend: bounded as that of a live process."""

import pytest

from clew.rehearsal.actor import Actor
from clew.rehearsal.mail import Mail
from clew.rehearsal.processes import Processes
from protocol.fence import Fence
from protocol.frames import Pose
from protocol.mission import RAYS_MAX
from protocol.network.bounded import INBOX_BYTES_MAX, INBOX_CAPACITY
from protocol.wire.codec import encode
from protocol.wire.messages import Ask, Message, Scan
from world.scenario.scenario import load

HERE = Pose(x_m=0.0, y_m=0.0, heading_rad=0.0)
LARGE = Scan(t_s=1.0, pose=HERE, fence=Fence(), ranges_m=(1.5,) * RAYS_MAX)


@pytest.fixture
def actor() -> Actor:
    return Processes(load("grove").mission(), 1).start(1)


def mail(number: int, message: Message) -> Mail:
    return Mail(0, 1, "body/r1/scan", number, message)


def test_mail_takes_as_many_bytes_as_its_message_and_its_key_on_a_live_network() -> None:
    said = mail(7, LARGE)
    assert said.size_bytes == len("body/r1/scan") + len(encode(LARGE, 7))


def test_a_robot_that_does_not_attend_keeps_the_newest_mail_up_to_a_number(actor: Actor) -> None:
    for number in range(1, INBOX_CAPACITY + 3):
        actor.wait(mail(number, Ask()))
    assert actor.traffic.overflowed_count == 2
    assert [item.number for item in actor.take_waiting()[:2] if isinstance(item, Mail)] == [3, 4]


def test_a_robot_that_does_not_attend_keeps_the_newest_mail_up_to_a_size(actor: Actor) -> None:
    fits = INBOX_BYTES_MAX // mail(1, LARGE).size_bytes
    for number in range(1, fits + 3):
        actor.wait(mail(number, LARGE))
    assert actor.traffic.overflowed_count == 2
    numbers = [item.number for item in actor.take_waiting() if isinstance(item, Mail)]
    assert numbers == list(range(3, fits + 3))
