"""A robot that dies has told the highest counts that a message has room for; the others count on."""

import pytest
from msgspec.structs import replace

from agents.liveness.reason import Reason
from agents.strand import member
from agents.strand.leader import Leader, Wait
from agents.strand.leading import Leading
from clew.explore.moments import WORLD
from clew.explore.setting import Setting
from protocol.fence import GENERATIONS_MAX, Cause, Epoch, May
from protocol.frames import COUNT_MAX, Point
from protocol.timeline import Entry, RouteLost, StepPlanned
from protocol.wire.codec import decode, encode
from protocol.wire.messages import LogBatch, Message
from protocol.wire.view import Counters, Report
from tests.support.stages.member_stage import MemberStage, row
from tests.support.stages.one_step import under
from tests.support.stages.view_stage import ViewStage, of

LAST = 3
QUEUE = tuple((0.4 + 0.5 * place, 1.0, 0.0) for place in (2, 1, 0))
LANE = Setting(
    name="lane", about="a way without a corner", places=QUEUE, goal_m=(7.0, 1.0), size_m=(8.0, 2.0)
)
MISSION = under("certified", robots=3, robot_radius_m=0.1, separation_m=0.1, goal=Point(x_m=6.0, y_m=0.0))
NEWEST = Epoch(generation=GENERATIONS_MAX, robot=LAST, life=1)
"""Newer than any strand: counters from there count."""


def arrives(message: Message) -> bool:
    """Whether a receiver's codec takes it."""
    return decode(encode(message, 1)) == (1, message)


@pytest.mark.parametrize(
    "lie",
    [
        {"map_number": COUNT_MAX},
        {"counters": Counters(steps=COUNT_MAX), "counted": NEWEST},
        {"counters": Counters(heals=COUNT_MAX), "counted": NEWEST},
    ],
    ids=["map", "steps", "heals"],
)
def test_what_robots_say_that_count_on_from_the_highest_count_arrives(lie: dict[str, object]) -> None:
    """Else one report of a robot that has died keeps a leader from all views, or its body from moving."""
    stage = ViewStage.begun(QUEUE, LANE.scenario())
    while stage.fence.may is not May.ALL:
        if stage.mail and of(Report, sender=LAST)(stage.mail[0]):
            stage.mail[0] = stage.mail[0]._replace(thing=replace(stage.mail[0].thing, **lie))
        stage.step()
    stage.run(lambda: bool(stage.records_of(StepPlanned)))
    stage.kill(LAST)
    stage.run(lambda: stage.fence.may is not May.ALL)
    stage.run(lambda: stage.fence.may is May.ALL)
    planned = len(stage.records_of(StepPlanned))
    stage.run(lambda: len(stage.records_of(StepPlanned)) > planned and bool(stage.moving()))
    assert all(arrives(post.thing) for post in stage.posted if post.sender != WORLD)
    noted = [Entry(n=1, t_s=0.0, hlc="", record=step) for step in stage.records_of(StepPlanned)]
    assert arrives(LogBatch(entries=tuple(noted)))


def test_attempts_in_vain_that_only_one_robot_tells_of_end_no_run() -> None:
    """One such report, which also named all robots as the last to lead, lost a leader its route at once."""
    stage = ViewStage.begun(QUEUE, LANE.scenario())
    told = Counters(in_vain=COUNT_MAX, last_to_lead=(1, 2, 3))
    while stage.fence.may is not May.ALL:
        if stage.mail and of(Report, sender=LAST)(stage.mail[0]):
            lie = replace(stage.mail[0].thing, counters=told, counted=NEWEST)
            stage.mail[0] = stage.mail[0]._replace(thing=lie)
        stage.step()
    assert stage.fence.epoch.robot != LAST, "it coordinates the view itself"
    stage.run(lambda: bool(stage.records_of(StepPlanned)))
    assert stage.records_of(RouteLost) == []


@pytest.mark.parametrize("cause", [Cause.DEAD_END, Cause.BLOCKED, Cause.NO_WAY])
def test_what_a_member_wants_counts_no_further_than_a_message_can_tell(
    monkeypatch: pytest.MonkeyPatch, cause: Cause
) -> None:
    monkeypatch.setattr(Leader, "plan", lambda *_, **__: Wait())
    monkeypatch.setattr(Leading, "reason", Reason(cause, "it wants a view"))
    monkeypatch.setattr(member, "IN_VAIN_MAX", COUNT_MAX)
    highest = Counters(in_vain=COUNT_MAX)
    stage = MemberStage(MISSION, row(3), (1, 2, 3), counters=highest)
    stage.run(0.2)
    assert stage.leader.reason == Reason(cause, "it wants a view")
    assert stage.leader.counters.in_vain == COUNT_MAX
