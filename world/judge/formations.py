"""F4: what the formation of an epoch must be, from the coordinator's entry and the fences; and P3.

Rule 1: the strand of an epoch drives only after the coordinator of that epoch, in that life, has recorded its
        formation, once. The fence ALL has the formation's turn, its leader and its number of members.
Rule 2: no robot has a turn after the formation is made. Just before ALL a turn names nobody, unless no turn
        of the epoch named a robot. So every place is read while nobody moves.
Rule 3: a robot records only its own rank in a formation of which it is a member.
Rule 4: a coordinator that was killed may not have recorded its formation. That excuses rules 1 and 3.
Rule 5 (P3): a formation names each robot once, with its life, and the places go back along the path from the
        leader to the tail.

`world.judge.authority` judges by orders whether members stand at their places.
"""

from collections.abc import Iterator
from itertools import pairwise

from protocol.fence import NUMBERS, May
from protocol.path import Path
from protocol.timeline import PromiseBroken, StrandFormed, StrandJoined
from world.judge.evidence import ROUNDING_M, Evidence, Formed
from world.judge.fences import ROUNDING_S

Dated = tuple[float, PromiseBroken]


def judge_formations(evidence: Evidence) -> Iterator[Dated]:
    """Every violation of F4 and P3 by formations, with its time."""
    for formed in evidence.formed_again:
        why = f"made another formation of epoch {formed.strand.epoch}"
        yield formed.t_s, broken("F4", formed.by, why, evidence.formed[formed.strand.epoch].by)
    for formed in evidence.formed.values():
        yield from ((formed.t_s, broken("P3", formed.by, why)) for why in _misshapen(formed.strand))
        yield from ((formed.t_s, broken("F4", formed.by, why)) for why in _unlawful(evidence, formed))
    for epoch in evidence.fences.of_epoch:
        driven = evidence.fences.all_of(epoch)
        if driven is not None:
            t_s, coordinator = evidence.fences.times_s[driven], max(evidence.fences[driven].coordinator, 1)
            yield from ((t_s, broken("F4", coordinator, why)) for why in _of_all(evidence, epoch, driven))


def judge_rank(evidence: Evidence, robot: int, t_s: float, joined: StrandJoined) -> PromiseBroken | None:
    """Rule 3."""
    driven, formed = evidence.fences.all_of(joined.epoch), evidence.formed.get(joined.epoch)
    if driven is None or evidence.fences.times_s[driven] > t_s + ROUNDING_S:
        return broken("F4", robot, f"takes its place in epoch {joined.epoch} before its strand may drive")
    if formed is None or formed.ranks.get(robot) == joined.rank:
        return None  # rule 1 asks for the formation
    has = formed.ranks.get(robot)
    told = "it is no member" if has is None else f"its rank is {has}"
    return broken("F4", robot, f"takes rank {joined.rank} in epoch {joined.epoch}, where {told}", formed.by)


def broken(invariant: str, robot: int, why: str, other: int | None = None) -> PromiseBroken:
    """A violation without a length."""
    return PromiseBroken(invariant=invariant, robot=robot, other=other, why=why)


def _misshapen(strand: StrandFormed) -> Iterator[str]:
    """Rule 5."""
    told = f"the formation of epoch {strand.epoch}"
    members = len(strand.order)
    if len(set(strand.order)) < members:
        yield f"{told} names a robot twice: {strand.order}"
    if not len(strand.lives) == len(strand.places_m) == members or not strand.laid:
        yield f"{told} has no life, no place or no path for some of its {members} members"
    elif Path(strand.laid).end_m < strand.places_m[0] - ROUNDING_M or any(
        ahead_m < behind_m - ROUNDING_M for ahead_m, behind_m in pairwise(strand.places_m)
    ):
        yield f"{told} has places that do not go back along its path from the leader to the tail"


def _unlawful(evidence: Evidence, formed: Formed) -> Iterator[str]:
    """Rules 1 and 2, from the formation."""
    strand, fences = formed.strand, evidence.fences
    coordinator, epoch = strand.epoch % NUMBERS, strand.epoch
    indices = fences.of_epoch.get(epoch, [])
    if formed.by != coordinator:
        yield f"made the formation of epoch {epoch}, which robot {coordinator} coordinates"
    if not indices or fences.times_s[indices[0]] > formed.t_s + ROUNDING_S:
        yield f"made the formation of epoch {epoch} before that was in force"
        return
    rank, life = formed.ranks.get(coordinator), fences[indices[0]].life
    if rank is not None and rank < len(strand.lives) and strand.lives[rank] != life:
        yield f"made the formation of epoch {epoch} in another life than {life}, which coordinates it"
    late = (
        index
        for index in indices
        if fences[index].may is May.ONE and fences.times_s[index] > formed.t_s + ROUNDING_S
    )
    if (index := next(late, None)) is not None:
        fence = fences[index]
        yield f"robot {fence.named} got turn {fence.turn} of epoch {epoch} after the formation was made"


def _of_all(evidence: Evidence, epoch: int, driven: int) -> Iterator[str]:
    """Rules 1 and 2, from the fence ALL."""
    fences, formed = evidence.fences, evidence.formed.get(epoch)
    fence, t_s = fences[driven], fences.times_s[driven]
    told = f"turn {fence.turn} of epoch {epoch} lets all move"
    earlier = [index for index in fences.of_epoch[epoch] if index < driven]
    if earlier and fences[earlier[-1]].may is not May.NOBODY:
        yield f"{told} right after a turn of robot {fences[earlier[-1]].named}"
    if formed is None:
        since_s = fences.times_s[earlier[-1]] if earlier else t_s
        if not evidence.may_have_said_more(epoch % NUMBERS, t_s, since_s=since_s):
            yield f"{told} without a formation"
        return
    strand = formed.strand
    if formed.t_s > t_s + ROUNDING_S:
        yield f"{told} before the formation was made"
    if strand.turn != fence.turn:
        yield f"{told}, and its formation names turn {strand.turn}"
    if (fence.named, fence.members) != (strand.order[0], len(strand.order)):
        led = f"robot {strand.order[0]} leads {len(strand.order)}"
        yield f"{told}, robot {fence.named} leading {fence.members}, and in its formation {led}"
