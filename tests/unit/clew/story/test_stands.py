"""Switching positions have the log's step numbers, however a step ended."""

from msgspec.structs import replace

from clew.story.stands import stands_of
from clew.story.story import Story
from protocol.frames import Point
from protocol.timeline import StepAbandoned
from tests.support.logs.logs import numbered
from tests.support.planned import planned
from tests.support.strands import ordered


def test_an_interrupted_step_ends_at_the_position_of_its_leaders_body() -> None:
    story = Story()
    for source, entry in numbered(
        (
            ("r1", planned(1)),
            ("world", ordered(1, step=1, epoch=1, x_m=0.0)),
            ("r1", StepAbandoned(step=1, epoch=1, x_m=0.4, y_m=0.0)),
            ("r1", planned(2)),
            ("world", ordered(1, step=2, epoch=1, x_m=0.4)),
            ("r2", replace(planned(2), epoch=2)),
            ("world", ordered(2, step=2, epoch=2, x_m=-0.3)),
        )
    ):
        story.hear(source, entry)
    stands = stands_of(story.all_steps(), lambda *_: Point(x_m=0.7, y_m=0.0))
    assert [(stand.name, stand.robot, stand.place.x_m) for stand in stands] == [
        ("1", 1, 0.0), ("2", 1, 0.4), ("2 end", 1, 0.7), ("2", 2, -0.3),
    ]  # fmt: skip
