"""Regression cases drawn by a swarm, in which a fleet once failed: `tests/rehearsals/drawn`.

Every failure prints the line that replays it.
"""

from collections.abc import Callable
from pathlib import Path

import pytest

from clew.campaign.liveness import at_end, liveness_failure
from clew.rehearsal.rehearsal import Rehearsal
from protocol.exit_codes import ExitCode
from protocol.faults.plan import load as load_plan
from protocol.fence import May
from protocol.timeline import FenceChanged, OrderAccepted, OrderRefused
from tests.support.long import long
from world.core import World
from world.judge.judgement import judge
from world.scenario.scenario import load

DRAWN = Path(__file__).parent / "drawn"


Healing = tuple[str, int, float, tuple[int, ...]]
"""Name, seed, from when on there is no fault any more, and who cannot be in the strand then."""

HEALS: list[Healing] = [
    # A robot that misses six of seven messages must not keep the others waiting.
    ("a-leader-nearly-deaf", 2394, 9.177, (1,)),
    # Dead robots do not come back, so it is useless to wait for them when no robot finds a place.
    ("waited-for-the-dead", 14064, 18.564, ()),
    # The last robot at the goal stands between the one ahead and a body: there is room before it only.
    ("between-a-body-and-the-robot-ahead", 260331, 16.686, ()),
    # A robot that has arrived alone stands so near to a body that no leg may end there.
    ("alone-at-the-goal-beside-a-body", 19064, 16.713, ()),
    # The leader is started again between the formation and its ALL, and is lost by that, not by silence.
    ("started-again-before-its-all", 321421, 7.079, ()),
]
HEALS_TOO: list[Healing] = [
    # `test_pleas.py`, `test_questions.py` and `test_agreeing.py` show in small what the first five show.
    # Beside another robot a corridor's mouth is too narrow, and its tail, who stands there, has to make room.
    ("squeezed-in-before-another", 532826, 17.8, ()),
    # The tail has to make room. A step of 3 cm further into a gap that is too narrow does not lead on.
    ("creeps-into-a-gap-instead-of-making-room", 535942, 11.728, ()),
    # A robot that was often let in in vain has to be let in again when the leader has arrived.
    ("let-in-in-vain-before-the-goal", 532969, 20.102, ()),
    # A robot that misses 24 of 25 messages does not answer about its leg, and is asked about another one.
    ("one-that-owes-an-answer", 541876, 11.697, (5,)),
    # Two are locked in a pocket by one that is lost again and again; the two outside have to go on.
    ("locked-in-behind-one-that-is-lost", 536267, 9.09, (1, 2, 3)),
    # The leader comes back in front of the robot that took its place, and has to lead again.
    ("leader-frozen-in-a-corridor", 5342, 9.783, ()),
    # The others come out of a dead end; the robot must not be called in before they are out.
    ("robot-before-a-pocket", 6006, 16.367, ()),
    # A robot that was cut off while a link was silent must not be shunned for that.
    ("two-cut-off-by-turns", 2544, 20.072, ()),
    # The robot that never answers keeps the others waiting, not the one that has the turn.
    ("one-that-never-answers", 2892, 17.196, (1,)),
    # A robot that comes back in front, round a corner, finds no way to the tail; the others can reach it.
    ("in-front-and-round-a-corner", 12858, 10.509, ()),
    # A robot that found no way to a place must ask again when the others have driven on.
    ("left-behind-when-the-others-drive-on", 991, 12.479, ()),
    # Three are locked in a pocket by a dead body; the one outside has to go on without them.
    ("outside-of-a-closed-pocket", 111623, 18.384, ()),
    # The leader stands between a wall and the next robot and knows no way on; the next robot does.
    ("bodies-beside-the-leader", 5511, 16.638, ()),
    # A robot that asks for another order must not ask a robot that never answers.
    ("the-tail-cut-off-for-good", 673, 16.585, (5,)),
    # The way back out of a pocket leads past the others that are still in it.
    ("out-of-a-pocket-round-a-loop", 869, 12.499, ()),
    # A leader that drives to and fro makes no room; the robot in its way has to be called in.
    ("room-made-to-and-fro", 3560, 14.339, ()),
    # A nearly mute robot keeps the strand waiting half of the time, but never for long.
    ("a-robot-nearly-mute-in-the-strand", 4782, 20.065, (3,)),
    # A nearly deaf robot must not report that the robots it misses do not answer.
    ("a-robot-nearly-deaf-that-calls", 5364, 16.447, (4,)),
    # The tail leads after a dead end, and only the robot behind it knows a way.
    ("led-by-the-tail-in-a-corridor", 2346, 15.049, ()),
    # One robot finds no way to a place under any leader; there is room when the others have gone on.
    ("no-room-for-the-last", 4891, 17.455, ()),
    # The robot that must give the first turn receives almost nothing, and does not give it.
    ("the-giver-nearly-deaf", 8811, 16.328, (1,)),
    # The trace of a body in the map, hidden by another body, closes the only gap after it has moved on.
    ("the-trace-of-a-body-that-moved-on", 10609, 11.659, ()),
    # A robot must not call in a robot that it shuns.
    ("called-in-by-one-that-shuns-it", 1614, 18.838, ()),
    # The body of a robot that is shunned stands in the way of the one that shuns it.
    ("shunned-in-a-pockets-mouth", 3410, 17.826, (2,)),
    # Two robots that are back cannot answer the call that the others wait in; they can report that.
    ("back-after-the-call", 18613, 17.813, (5,)),
    # A robot that can never come must not keep robots that are nearly there from arriving.
    ("locked-out-by-two-bodies", 1619, 13.412, (5,)),
    # A robot that misses six of seven messages and scans must not wait for one scan after the other.
    ("nearly-deaf-in-a-pockets-mouth", 11139, 19.277, (3,)),
    # Of two robots that do not hear each other, the one that others hear well must not be left out.
    ("a-leader-nearly-mute", 6164, 20.229, (2,)),
    # A robot that is left out for a silence counts in the same view as soon as that has passed.
    ("shunned-in-front-in-a-corridor", 70159, 10.9, ()),
]


def rehearsed(name: str, seed: int, *, decided: Callable[[World], bool]) -> tuple[Rehearsal, str]:
    """The run up to when it is decided, in which no invariant was broken, and the line that replays it."""
    world, plan = DRAWN / f"{name}.toml", DRAWN / f"{name}.faults.toml"
    again = f"replay with  ./launch/clew rehearse {world} --faults {plan} --seed {seed}"
    rehearsal = Rehearsal(load(str(world)), seed, load_plan(str(plan)))
    for _ in rehearsal.ticks():
        if decided(rehearsal.world):
            rehearsal.stop(ExitCode.INTERRUPTED)
    assert judge(rehearsal.world.scenario, rehearsal.entries).breaches == (), again
    return rehearsal, again


@pytest.mark.parametrize(("name", "seed", "quiet_s", "outside"), [*HEALS, *long(HEALS_TOO)])
def test_a_fleet_heals_in_a_case_in_which_it_once_did_not(
    name: str, seed: int, quiet_s: float, outside: tuple[int, ...]
) -> None:

    def have_arrived(world: World) -> bool:
        """They have healed and arrived together; what a robot outside does then is asked of no one."""
        return world.now_s > quiet_s and set(world.attendance.living) - set(outside) <= world.tally.arrived

    rehearsal, again = rehearsed(name, seed, decided=have_arrived)
    said = liveness_failure(
        at_end(rehearsal.world), rehearsal.entries, quiet_s=quiet_s, outside=frozenset(outside)
    )
    assert said is None, again


@pytest.mark.parametrize(
    ("name", "seed"),
    [
        # A body comes to rest beside a leg after the scan that shows the leg clear, before any robot drives.
        ("a-body-that-came-to-rest-late", 6337),
        # A robot that backed up in a strand that turned round has left its former place.
        ("a-place-from-before-the-turn", 1447),
        # A restarted robot must not answer a call from before its start, even by a tenth of a second.
        ("a-call-from-just-before-a-restart", 18906),
        # A robot that is left out comes to rest beside driven ground; `test_follower.py` shows it in small.
        *long([("a-body-beside-driven-ground", 1538)]),
        # Found by reading: a robot must forget that another one stands if that was in a later epoch since.
        ("left-out-of-two-epochs", 1),
        # The leader began too near to a pedestrian and stays there, so the next robot has to come up to it.
        ("arrived-where-it-began-too-near", 13961),
        # A robot without a way on that does not trust a silence yet must not scan without pause.
        ("a-leader-that-has-slept", 6498),
    ],
)
def test_a_fleet_breaks_no_invariant_in_a_case_in_which_it_once_did(name: str, seed: int) -> None:
    rehearsal, again = rehearsed(name, seed, decided=lambda _: False)
    assert rehearsal.world.ending, again


def test_a_turn_is_taken_back_while_its_orders_are_on_their_way_and_the_bodies_refuse_them() -> None:
    """Robot 3 is cut off while robot 1 joins. It is back, raises, and has the next turn but one."""
    rehearsal, again = rehearsed("a-lease-taken-back", 1, decided=lambda _: False)
    records = [(entry.t_s, entry.record) for _, entry in rehearsal.entries]
    fences = [(t_s, record) for t_s, record in records if isinstance(record, FenceChanged)]
    first, raised = (
        next(t_s for t_s, fence in fences if (fence.epoch, fence.turn) == at)
        for at in ((10_001, 1), (20_003, 0))
    )
    assert first < raised, again
    refused = [record for t_s, record in records if isinstance(record, OrderRefused) and t_s > raised]
    told = [(each.robot, each.epoch, each.turn, each.fence, each.fence_turn) for each in refused]
    assert told == [(1, 10_001, 1, 20_003, 1), (1, 20_003, 1, 20_003, 2)], again
    names = [(fence.turn, fence.named) for _, fence in fences if fence.may is May.ONE]
    assert names == [(1, 1), (1, 1), (2, 3)], again
    third = [
        (record.epoch, record.turn)
        for _, record in records
        if isinstance(record, OrderAccepted) and record.robot == 3
    ]
    assert (20_003, 2) in third, again
