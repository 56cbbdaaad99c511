"""What a coordinator counts for the next formation."""

import pytest

from agents.coordinating.agreeing import Agreement, Intent
from protocol.fence import Cause, Epoch
from protocol.frames import Pose
from protocol.wire.view import Counters, Former, Report

ENDED, EPOCH = Epoch(generation=1, robot=1, life=5), Epoch(generation=2, robot=2, life=6)
HERE = Pose(x_m=0.0, y_m=0.0, heading_rad=0.0)
DRAFTED = Former(epoch=ENDED, rank=2, draft=True)


def report(robot: int, *formers: Former) -> Report:
    return Report(
        epoch=EPOCH,
        life=robot,
        number=1,
        turn=0,
        place=HERE,
        formers=formers,
        counters=Counters(led_in_vain=(2,)),
        counted=ENDED,
    )


@pytest.mark.parametrize(("is_closed", "led"), [(False, (2,)), (True, (2, 1, 3))])
def test_all_robots_of_a_closed_strand_have_led_in_vain_and_those_that_were_left_out_have_not(
    led: tuple[int, ...], *, is_closed: bool
) -> None:
    members = {robot: report(robot, Former(epoch=ENDED, rank=robot - 1)) for robot in (1, 2, 3)}
    reports = {**members, 4: report(4), 5: report(5, DRAFTED)}
    intent = Intent(Cause.NO_WAY, 2, is_closed=is_closed, ended=ENDED)
    agreement = Agreement(2, EPOCH, intent, sensed=False, neighbours={})
    assert agreement.counters(reports).led_in_vain == led
