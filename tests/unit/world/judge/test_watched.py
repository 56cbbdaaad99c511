"""S3: no body moves unwatched, and what the world says of its place agrees with its samples."""

from collections.abc import Callable

import pytest
from msgspec.structs import replace

from protocol.exit_codes import ExitCode
from protocol.frames import Point
from protocol.keys import WORLD
from protocol.timeline import (
    Entry,
    OrderAccepted,
    OrderFinished,
    PoseSampled,
    PromiseBroken,
    RunEnded,
    ScanServed,
    StepFinished,
)
from tests.support.scenes.world_scenarios import scenario
from tests.support.stages.world_stage import Stage
from world.events import ScanAsked, StopAsked
from world.judge.judgement import judge

Lines = list[tuple[str, Entry]]

OFF_M = 0.002


def driven() -> Stage:
    """A leader drives a step of 0.8 m; another robot drives up, and is scanned on its way."""
    stage = Stage(scenario())
    stage.begin()
    stage.lead(1, Point(x_m=0.8, y_m=0.0))
    stage.tick(100)
    stage.order(2, Point(x_m=-0.4, y_m=0.0))
    stage.tick(7)
    stage.handle(ScanAsked(2, 1))
    stage.tick(50)
    return stage


def ended(stage: Stage) -> Lines:
    stage.handle(StopAsked(ExitCode.INTERRUPTED))
    return stage.lines


def found(lines: Lines) -> list[PromiseBroken]:
    """What of S3 is broken in these lines."""
    breaches = judge(scenario(), lines).breaches
    return [each.broken for each in breaches if each.broken.invariant == "S3"]


def sampled(entry: Entry, robot: int, from_s: float, to_s: float) -> bool:
    record = entry.record
    return isinstance(record, PoseSampled) and record.robot == robot and from_s < entry.t_s < to_s


def test_the_samples_of_a_world_are_the_whole_motion_also_of_one_that_was_resumed() -> None:
    stage = driven()
    stage.order(2, Point(x_m=-0.2, y_m=0.0), number=2)
    stage.tick(13)
    assert found(ended(stage.resumed())) == []


@pytest.mark.parametrize(("from_s", "to_s", "count"), [(0.42, 0.58, 1), (0.45, 0.9, 1), (0.55, 0.55, 0)])
def test_a_way_between_two_samples_that_took_longer_than_0_1_s_was_not_watched(
    from_s: float, to_s: float, count: int
) -> None:
    # The way is straight and even, so by its two ends alone there is nothing against it.
    lines = [(source, each) for source, each in ended(driven()) if not sampled(each, 1, from_s, to_s)]
    broken = found(lines)
    assert len(broken) == count
    assert all("was not sampled for" in each.why and each.robot == 1 for each in broken)


def test_a_body_that_a_resumed_world_puts_further_on_along_its_way_has_moved_unwatched() -> None:
    stage = driven()
    stage.order(2, Point(x_m=-0.2, y_m=0.0), number=2)
    stage.tick(13)
    until_s = stage.world.now_s + 0.01
    lines = ended(stage.resumed())
    unseen = [(source, each) for source, each in lines if not sampled(each, 2, until_s - 0.15, until_s)]
    (breach,) = found(unseen)
    assert breach.robot == 2
    assert "moved, and was not sampled for 1." in breach.why


Told = OrderAccepted | OrderFinished | ScanServed | StepFinished


@pytest.mark.parametrize(
    ("kind", "said"),
    [
        (OrderAccepted, "order.accepted"),
        (OrderFinished, "order.finished"),
        (ScanServed, "scan.served"),
        (StepFinished, "step.finished"),
    ],
)
@pytest.mark.parametrize("moved", [lambda pose: pose.x_m - OFF_M, lambda pose: pose.x_m + OFF_M])
def test_a_place_that_the_world_tells_and_its_samples_do_not_show_is_a_violation(
    kind: type[Told], said: str, moved: Callable[[Told], float]
) -> None:
    lines = ended(driven())
    lies = [
        (source, replace(each, record=replace(each.record, x_m=moved(each.record))))
        if isinstance(each.record, kind)
        else (source, each)
        for source, each in lines
    ]
    broken = [each for each in found(lies) if "by its samples" in each.why]
    assert {each.why for each in broken} == {f"is elsewhere than {said} says, by its samples"}
    assert broken[0].measured_m == pytest.approx(OFF_M)


def test_a_log_that_is_cut_off_does_not_show_that_a_body_stood() -> None:
    lines = ended(driven())
    for cut in range(1, len(lines)):
        assert found(lines[:cut]) == [], f"cut behind {lines[cut - 1]}"


def jumped(lines: Lines) -> tuple[str, Entry]:
    """The world says last that body 1 is aside of where it stands."""
    told = next(each for _, each in lines if isinstance(each.record, OrderFinished))
    assert isinstance(told.record, OrderFinished)
    aside = replace(told.record, y_m=told.record.y_m + OFF_M)
    return WORLD, replace(told, t_s=lines[-1][1].t_s, record=aside)


@pytest.mark.parametrize(("later_s", "is_seen"), [(0.08, False), (0.12, True)])
def test_a_cut_log_shows_a_jump_if_a_sample_was_due_since(later_s: float, is_seen: bool) -> None:
    lines = ended(driven())
    source, last = lines[-1]  # a sample of body 2
    newest = source, replace(last, t_s=last.t_s + later_s)
    assert [each.robot for each in found([*lines, jumped(lines), newest])] == [1] * is_seen


def test_a_whole_log_shows_a_jump_up_to_its_last_entry() -> None:
    lines = ended(driven())
    end = WORLD, replace(lines[-1][1], record=RunEnded(reason="interrupted"))
    assert [each.robot for each in found([*lines, jumped(lines), end])] == [1]


def test_no_robot_can_say_for_the_world_where_a_body_is() -> None:
    lines = ended(driven())
    said = OrderFinished(robot=1, number=1, step=1, x_m=9.0, y_m=9.0, clearance_m=None)
    forged = Entry(n=1, t_s=lines[-1][1].t_s, hlc="", record=said)
    assert found([*lines, ("r2", forged)]) == []
