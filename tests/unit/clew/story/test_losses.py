"""Messages that faults removed, and message counts of links, some of which are unknown."""

import pytest

from clew.story.losses import Book, Losses
from protocol.timeline import FaultInjected, Record, RobotRestarted, RobotSettled, TrafficCounted
from tests.support.logs.logs import numbered


def heard(*records: tuple[str, Record]) -> Losses:
    losses = Losses()
    for source, entry in numbered(records):
        losses.hear(source, entry)
    return losses


def counted(received: dict[str, int]) -> TrafficCounted:
    return TrafficCounted(sent={}, received=received, newest={}, refused={}, overflowed=0, unrecorded=0)


BOOKS: tuple[tuple[str, Record], ...] = (
    ("r1", RobotSettled(sent={"link/r1/r2": 112})),
    ("r2", RobotSettled(sent={"link/r2/r1": 91})),
    ("r1", counted({"link/r2/r1": 90})),
    ("r2", counted({"link/r1/r2": 93})),
)


def test_the_counts_of_both_robots_give_the_losses_of_a_link() -> None:
    assert heard(*BOOKS).books() == (
        Book(sender=1, receiver=2, sent=112, received=93, injected=0),
        Book(sender=2, receiver=1, sent=91, received=90, injected=0),
    )


def test_the_losses_on_links_of_a_restarted_robot_are_unknown() -> None:
    assert heard(*BOOKS, ("world", RobotRestarted(robot=2))).books() == (
        Book(sender=1, receiver=2, sent=112, received=None, injected=0),
        Book(sender=2, receiver=1, sent=None, received=90, injected=0),
    )


@pytest.mark.parametrize(
    ("source", "key", "fault", "robot", "link"),
    [
        ("r1", "link/r2/r1", "drop", 1, (2, 1)),
        ("r1", "body/r1/odometry", "partition", 1, None),
        ("world", "body/r1/drive", "corrupt", 1, None),
        ("r2", "link/r1/r2", "drop", 2, (1, 2)),
        ("r2", "view/r1/r2", "drop", 2, None),
        ("world", "body/fence/r2", "drop", 2, None),
        ("world", "body/fence/0", "drop", None, None),
        ("r1", "link/r2/r1", "delay", None, None),
        ("r1", "body/r1/scan", "drop", None, None),
    ],
)
def test_a_message_is_lost_at_its_receiver(
    source: str, key: str, fault: str, robot: int | None, link: tuple[int, int] | None
) -> None:
    losses = heard((source, FaultInjected(fault=fault, rule="a", key=key, number=1)))
    assert dict(losses.by_robot) == ({} if robot is None else {robot: 1})
    assert [each for _, each in losses.taken] == ([] if link is None else [link])
