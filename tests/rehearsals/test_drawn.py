"""Worlds and fault plans that a swarm drew, and that a fleet once did not get over: `tests/rehearsals/drawn`.

Every failure says the line that replays it.
"""

from collections.abc import Callable
from pathlib import Path

import pytest
from msgspec.structs import replace

from clew.campaign.liveness import unlively
from clew.rehearsal.rehearsal import Rehearsal
from protocol.exit_codes import ExitCode
from protocol.faults.plan import load as load_plan
from protocol.timeline import MusterCalled, RobotArrived
from world.core import World
from world.judge.judgement import judge
from world.scenario.scenario import load

DRAWN = Path(__file__).parent / "drawn"


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


@pytest.mark.parametrize(
    ("name", "seed", "quiet_s", "outside"),
    [
        # It comes back in front of the robot that took its place, and has to lead again.
        ("leader-frozen-in-a-corridor", 5342, 9.783, ()),
        # The one that leads stands between a wall and the next robot, and knows no way on; the next does.
        ("bodies-beside-the-leader", 5511, 16.638, ()),
        # The others come out of a dead end, and it must not be called in among them before they are out.
        ("robot-before-a-pocket", 6006, 16.367, ()),
        # Whoever asks for another order must not ask one that never answers.
        ("the-tail-cut-off-for-good", 673, 16.585, (5,)),
        # Who was cut off while a link was silent is not to be shunned for that.
        ("two-cut-off-by-turns", 2544, 20.072, ()),
        # Who misses six of seven messages must not keep the others waiting.
        ("a-leader-nearly-deaf", 2394, 9.177, (1,)),
        # The way back out of a pocket leads past the others that are still in it.
        ("out-of-a-pocket-round-a-loop", 869, 12.499, ()),
        # A leader that makes room to and fro makes none, and has to have the one in its way called in.
        ("room-made-to-and-fro", 3560, 14.339, ()),
        # Who is nearly mute keeps the strand waiting, half of the time though never for long.
        ("a-robot-nearly-mute-in-the-strand", 4782, 20.065, (3,)),
        # Who is nearly deaf must not say of those that it misses that they do not answer.
        ("a-robot-nearly-deaf-that-calls", 5364, 16.447, (4,)),
        # Who never answers, not who has the turn, keeps the others waiting.
        ("one-that-never-answers", 2892, 17.196, (1,)),
        # The tail leads after a dead end, and only the one that it has behind it knows a way.
        ("led-by-the-tail-in-a-corridor", 2346, 15.049, ()),
        # One finds no way to a place, whoever leads; there is room for it when the others have gone on.
        ("no-room-for-the-last", 4891, 17.455, ()),
        # The robot that has to give the first turn hears next to nothing, and does not do it.
        ("the-giver-nearly-deaf", 8811, 16.328, (1,)),
        # What a body leaves in the map, in the shadow of another, closes the only gap when it has moved on.
        ("the-trace-of-a-body-that-moved-on", 10609, 11.659, ()),
        # Who comes back in front, round a corner, finds no way to the tail; the others can come to it.
        ("in-front-and-round-a-corner", 12858, 10.509, ()),
        # Who shuns a robot must not call it in.
        ("called-in-by-one-that-shuns-it", 1614, 18.838, ()),
        # The body of a robot that is shunned stands in the way of the one that shuns it.
        ("shunned-in-a-pockets-mouth", 3410, 17.826, (2,)),
        # Two that have come back cannot answer the call that the others wait in; they can say so.
        ("back-after-the-call", 18613, 17.813, (5,)),
        # Who can never come must not keep those from arriving that are nearly there.
        ("locked-out-by-two-bodies", 1619, 13.412, (5,)),
        # Who misses six of seven messages, scans too, must not wait for one scan after the other.
        ("nearly-deaf-in-a-pockets-mouth", 11139, 19.277, (3,)),
        # Of two that do not hear each other the one that others hear well must not be left out.
        ("a-leader-nearly-mute", 6164, 20.229, (2,)),
        # The dead do not come back: it is no use to wait for them whenever nobody finds a place.
        ("waited-for-the-dead", 14064, 18.564, ()),
    ],
)
def test_a_fleet_gets_over_what_it_once_did_not(
    name: str, seed: int, quiet_s: float, outside: tuple[int, ...]
) -> None:

    def have_arrived(world: World) -> bool:
        """They have healed and arrived together; what a robot outside does then is asked of no one."""
        return world.now_s > quiet_s and set(world.attendance.living) - set(outside) <= world.tally.arrived

    rehearsal, again = rehearsed(name, seed, decided=have_arrived)
    said = unlively(rehearsal.world, rehearsal.entries, quiet_s=quiet_s, outside=frozenset(outside))
    assert said is None, again


@pytest.mark.parametrize(
    ("name", "seed"),
    [
        # A body comes to rest beside a leg after the scan that shows the leg clear, before anybody drives.
        ("a-body-that-came-to-rest-late", 6337),
        # Who has backed up in a strand that turned round has left the place that it had before.
        ("a-place-from-before-the-turn", 1447),
        # Who is started again must not answer a call that was made before, by a tenth of a second even.
        ("a-call-from-just-before-a-restart", 18906),
        # Who is left out has come to rest beside ground that others have driven before.
        ("a-body-beside-driven-ground", 1538),
        # Found by reading: a robot must not remember that another stands that has been in a later epoch.
        ("left-out-of-two-epochs", 1),
        # Who knows no way on, and does not believe a silence yet, must not look again and again at once.
        ("a-leader-that-has-slept", 6498),
    ],
)
def test_a_fleet_keeps_its_promises_where_it_once_did_not(name: str, seed: int) -> None:
    rehearsal, again = rehearsed(name, seed, decided=lambda _: False)
    assert rehearsal.world.ending, again


def test_who_is_locked_out_is_left_behind_and_other_orders_are_tried_when_the_rest_have_arrived() -> None:
    world, plan = (str(DRAWN / f"locked-out-by-two-bodies{kind}.toml") for kind in ("", ".faults"))
    kills = replace(load_plan(plan), rules=load_plan(plan).rules[:1])  # it hears well
    records = [(entry.t_s, entry.record) for _, entry in Rehearsal(load(world), 1619, kills).run().entries]
    arrived_s = next(at_s for at_s, record in records if isinstance(record, RobotArrived))
    in_vain = [
        (at_s > arrived_s, record.members)
        for at_s, record in records
        if isinstance(record, MusterCalled) and record.why.startswith("no way to a place")
    ]
    assert {members for after, members in in_vain if not after} == {(1, 2)}
    assert next(members for after, members in in_vain if after) == (1, 2, 5)
