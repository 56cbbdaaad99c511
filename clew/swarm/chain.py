"""A chain: a seed's own faults, and a strike wherever a view begins. A shell.

Rule 1: an instant is the start of a run, or a new epoch of the fence. There the robots agree anew on who may
        move, and messages from before are still on their way. Each is struck.
Rule 2: each strike begins a branch of the run that is going on (`futures`), so nothing is played twice. The
        run ends soon after its last strike, and is the same to the byte as the future with its branches.
Rule 3: who is struck depends on the seed and on the run up to there, on nothing else. So a chain is the same
        every time, and knows nothing of other seeds.
Rule 4: some seeds are never struck. Their runs go on to the end, and are checked for healing and arrival,
        too.
"""

from collections.abc import Iterator, Sequence

from clew.rehearsal.rehearsal import Rehearsal
from clew.swarm.draws import Draws
from clew.swarm.futures import Branches, branch_at, branched
from clew.swarm.swarm import Swarm

PLAIN = 0.05  # share of seeds that are never struck: a fifth of all CPU time, as their runs are long
STRIKES_MAX = 12  # so many branches fit into the name of a file


def play_chain(rehearsal: Rehearsal, swarm: Swarm) -> Iterator[tuple[Branches, Swarm]]:
    """Play a rehearsal of this swarm to its end; yields all branches and their swarm at each strike."""
    draws, branches, epoch = Draws(swarm.seed, "chain"), Branches(), None
    strikes_max = 0 if draws.chance(PLAIN) else STRIKES_MAX
    for now_s in rehearsal.ticks():
        if len(branches) == strikes_max or epoch == rehearsal.world.arena.fence.epoch:
            continue
        epoch = rehearsal.world.arena.fence.epoch
        branches = (*branches, branch_at(now_s, draws.pick(_in_focus(rehearsal)), 1))
        swarm = branched(swarm, branches)
        rehearsal.turn_to(swarm.plan)
        rehearsal.world.limit(float(swarm.world["time"]["time_s_max"]))
        yield branches, swarm


def _in_focus(rehearsal: Rehearsal) -> Sequence[int]:
    """The robots on which most depends now: the view's coordinator; any, where there is none."""
    coordinator = rehearsal.world.arena.fence.epoch.robot
    return [coordinator] if coordinator else range(1, len(rehearsal.world.bodies.moving) + 1)
