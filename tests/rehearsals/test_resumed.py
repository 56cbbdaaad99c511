"""A world that is killed between any two of its commands, and resumed from its timeline alone.

In other rehearsals the new process has the state of the old one. Here it has what `world.record.resume`
reads, as in a live run; its clock goes on a second later, and obstacles that move have moved on.
"""

import random

import pytest

from clew.rehearsal.rehearsal import Rehearsal
from protocol.faults.plan import Plan
from protocol.faults.process_faults import ProcessAction, ProcessFault
from protocol.faults.rules import Kill, Restart
from protocol.fence import May
from protocol.keys import WORLD
from protocol.timeline import FenceChanged, WorldResumed
from tests.support.logs.logs import HEADER
from tests.support.long import long
from world.commands import Command
from world.core import World
from world.events import EntryRead
from world.judge.judgement import judge
from world.record.resume import Past
from world.scenario.scenario import Scenario, load

CASES = [(name, seed) for seed in (1, 2, 3, 4) for name in ("pedestrian", "follower", "door")]
EVERY_S = (0.3, 4.0)
KILLS = 6


class Resumed(Rehearsal):
    """A rehearsal whose world dies some times, each time before it has obeyed all of its commands."""

    def __init__(self, scenario: Scenario, seed: int, plan: Plan) -> None:
        self._random = random.Random(seed)
        self._next_s, self._left = self._random.uniform(*EVERY_S), KILLS
        super().__init__(scenario, seed, plan)

    def _execute_world(self, commands: list[Command]) -> None:
        if not commands or not self.world.started or self.world.ending is not None:
            return super()._execute_world(commands)
        if self._left == 0 or self.world.now_s < self._next_s:
            return super()._execute_world(commands)
        super()._execute_world(commands[: self._random.randrange(len(commands) + 1)])
        self._left -= 1
        self._next_s = self.world.now_s + self._random.uniform(*EVERY_S)
        return self._resume()

    def _resume(self) -> None:
        now_s, lines = self.world.now_s, list(self.entries)
        for action in (ProcessAction.KILL, ProcessAction.START):
            self.processes.inject(ProcessFault("killed", action, WORLD), now_s)
        past = Past(HEADER, 0, 0, lines)
        self.world = World(self.world.scenario, seed=self._random.randrange(99), wall_s=now_s, past=past)
        for source, entry in lines:
            self.world.handle(EntryRead(source, entry), wall_s=now_s)
        super()._execute_world(self.world.resume(wall_s=now_s))


LOSSES = Plan(
    name="losses",
    rules=(
        Restart(name="leader", target="leader", from_s=5.0, after_s=0.5),
        Kill(name="tail", target="tail", from_s=9.0),
    ),
)


@pytest.mark.parametrize(("name", "seed"), [CASES[0], *long(CASES[1:])])
def test_where_obstacles_move_and_robots_die_a_world_that_is_resumed_breaks_no_promise(
    name: str, seed: int
) -> None:
    rehearsal = Resumed(load(name, time_s_max=40.0), seed, LOSSES)
    rehearsal.run()
    records = [entry.record for _, entry in rehearsal.entries]
    assert sum(isinstance(each, WorldResumed) for each in records) == KILLS
    fences = [each for each in records if isinstance(each, FenceChanged)]
    assert sum(each.may is May.ALL for each in fences) > 1, "strands form again"
    assert judge(rehearsal.world.scenario, rehearsal.entries).breaches == ()
