"""Switching positions bear the log's numbers of steps, wherever a step ended."""

from clew.story.stands import stands_of
from protocol.timeline import OrderAccepted, PoseSampled, StepAbandoned
from tests.support.logs.logs import numbered
from world.judge.evidence import Evidence


def test_a_step_that_was_abandoned_or_whose_leader_died_ends_where_its_body_was() -> None:
    lines = numbered(
        (
            ("world", began(1, step=1, epoch=1, x_m=0.0)),
            ("r1", StepAbandoned(step=1, epoch=1, x_m=0.4, y_m=0.0)),
            ("world", began(1, step=2, epoch=1, x_m=0.4)),
            ("world", PoseSampled(robot=1, x_m=0.7, y_m=0.0, heading_rad=0.0)),
            ("world", began(2, step=2, epoch=2, x_m=-0.3)),
        )
    )
    evidence = Evidence()
    for source, entry in lines:
        evidence.hear(source, entry)
    stands = stands_of(lines, {1: 1, 2: 2}, evidence)
    assert [(stand.name, stand.robot, stand.place.x_m) for stand in stands] == [
        ("1", 1, 0.0), ("2", 1, 0.4), ("2 end", 1, 0.7), ("2", 2, -0.3),
    ]  # fmt: skip


def began(robot: int, *, step: int, epoch: int, x_m: float) -> OrderAccepted:
    return OrderAccepted(
        robot=robot, number=1, epoch=epoch, step=step, x_m=x_m, y_m=0.0, target=None, reach_m=0.0
    )
