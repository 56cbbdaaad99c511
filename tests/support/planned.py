"""A planned switching step, for tests that need little of it."""

from protocol.frames import Point
from protocol.timeline import StepPlanned


def planned(step: int) -> StepPlanned:
    return StepPlanned(
        step=step,
        epoch=1,
        law="certified",
        x_m=0.0,
        y_m=0.0,
        obstacles=(),
        gaps=(),
        gap=None,
        heading_rad=0.0,
        length_m=1.0,
        target=Point(x_m=1.0, y_m=0.0),
        reach_m=1.0,
        promised_clearance_m=None,
        cost_to_go_m=None,
    )
