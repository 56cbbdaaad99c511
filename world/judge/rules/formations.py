"""F4: what the formation of an epoch must be, from the coordinator's entry and the fences; and P3.

Rule 1: the strand of an epoch drives only after the coordinator of that epoch, in that life, has recorded its
        formation, once. The fence ALL has the formation's turn, its leader and its number of members.
Rule 2: no robot has a turn after the formation is made. Just before ALL a turn names nobody, unless no turn
        of the epoch named a robot. So every place is read while nobody moves.
Rule 3: a robot records only its own rank in a formation of which it is a member.
Rule 4: a coordinator that was killed may not have recorded its formation. That excuses rules 1 and 3.
Rule 5 (P3): a formation names each robot once, with its life, and the places go back along the path from the
        leader to the tail.

`world.judge.rules.authority` judges by orders whether members stand at their places.
"""

from collections.abc import Iterator
from itertools import pairwise

from protocol.fence import NUMBERS, May
from protocol.keys import WORLD, robot_name, robot_number
from protocol.path import Path
from protocol.timeline import Entry, FenceChanged, PromiseBroken, StrandFormed, StrandJoined
from world.judge.rules.claims import ROUNDING_S, Check, Claim, Claims
from world.judge.rules.evidence import ROUNDING_M, Evidence, Formed
from world.judge.rules.rule import Dated, broken


class Formations:
    """F4 and P3, by what coordinators and members record and by the fences."""

    kinds = frozenset[type]({FenceChanged, StrandFormed, StrandJoined})

    def __init__(self, evidence: Evidence, claims: Claims) -> None:
        self._evidence = evidence
        self._claims = claims
        self._made: dict[int, Formed] = {}
        """Formations of epochs that were in force: no robot has a turn after one."""

    def hear(self, source: str, entry: Entry) -> Iterator[Dated]:
        """Process an entry about a formation."""
        robot = robot_number(source)
        match entry.record:
            case FenceChanged() as change if source == WORLD:
                yield from self._late_turn(entry.t_s, change)
                if change.may is May.ALL and self._evidence.fences.all_of(change.epoch) == self._newest:
                    yield from self._claims.judge(entry.t_s, change.epoch, self._of_all(change.epoch))
            case StrandFormed() as strand if robot is not None:
                yield from self._hear_formation(entry.t_s, robot, strand)
            case StrandJoined() as joined if robot is not None:
                yield from self._claims.judge(entry.t_s, joined.epoch, self._of_rank(robot, joined))
            case _:
                pass  # of a source that has no say in it

    def close(self) -> Iterator[Dated]:
        """Nothing is open but claims."""
        return iter(())

    @property
    def _newest(self) -> int:
        return self._evidence.fences.newest

    def _hear_formation(self, t_s: float, robot: int, strand: StrandFormed) -> Iterator[Dated]:
        first = self._evidence.formed[strand.epoch]
        if first.strand is not strand:
            yield t_s, broken("F4", robot, f"made another formation of epoch {strand.epoch}", first.by)
            return
        yield from ((t_s, broken("P3", robot, why)) for why in _misshapen(strand))
        yield from self._claims.judge(t_s, strand.epoch, self._of_making(first))

    def _of_making(self, formed: Formed) -> Check:
        def check(claim: Claim) -> list[PromiseBroken] | frozenset[str]:
            indices = self._evidence.fences.of_epoch.get(formed.strand.epoch)
            if not indices and claim.may_hear(WORLD):
                return frozenset({WORLD})
            return [broken("F4", formed.by, why) for why in self._unlawful(formed)]

        return check

    def _unlawful(self, formed: Formed) -> Iterator[str]:
        """Rules 1 and 2, from the formation."""
        strand, fences = formed.strand, self._evidence.fences
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
        self._made = {each: made for each, made in self._made.items() if each in self._evidence.formed}
        self._made[epoch] = formed
        for index in indices:
            yield from (breach.why for _, breach in self._late_turn(fences.times_s[index], fences[index]))

    def _late_turn(self, t_s: float, fence: FenceChanged) -> Iterator[Dated]:
        """Rule 2: a robot gets a turn after the formation was made; said once for each formation."""
        formed = self._made.get(fence.epoch)
        if fence.may is May.ONE and formed is not None and t_s > formed.t_s + ROUNDING_S:
            del self._made[fence.epoch]
            told = f"turn {fence.turn} of epoch {fence.epoch}"
            why = f"robot {fence.named} got {told} after the formation was made"
            yield formed.t_s, broken("F4", formed.by, why)

    def _of_all(self, epoch: int) -> Check:
        """Rules 1 and 2, from the fence ALL."""
        fences = self._evidence.fences
        driven = fences.newest
        fence, t_s = fences[driven], fences.times_s[driven]
        coordinator = epoch % NUMBERS
        earlier = [index for index in fences.of_epoch[epoch] if index < driven]

        def check(claim: Claim) -> list[PromiseBroken] | frozenset[str]:
            formed = self._evidence.formed.get(epoch)
            if formed is None and claim.may_hear(robot_name(coordinator)):
                return frozenset({robot_name(coordinator)})
            since_s = fences.times_s[earlier[-1]] if earlier else t_s
            heard_s = claim.heard_after_s(robot_name(coordinator))
            may_be_missing = self._evidence.may_have_said_more(coordinator, t_s, heard_s, since_s=since_s)
            before = fences[earlier[-1]] if earlier else None
            whys = _of_driving(fence, before, formed, t_s, may_be_missing=may_be_missing)
            return [broken("F4", max(fence.coordinator, 1), why) for why in whys]

        return check

    def _of_rank(self, robot: int, joined: StrandJoined) -> Check:
        """Rule 3."""
        epoch, fences = joined.epoch, self._evidence.fences

        def check(claim: Claim) -> list[PromiseBroken] | frozenset[str]:
            driven, formed = fences.all_of(epoch), self._evidence.formed.get(epoch)
            if driven is None or fences.times_s[driven] > claim.t_s + ROUNDING_S:
                told = f"takes its place in epoch {epoch} before its strand may drive"
                return frozenset({WORLD}) if claim.may_hear(WORLD) else [broken("F4", robot, told)]
            if formed is None:  # rule 1 asks for the formation
                return claim.awaiting(robot_name(epoch % NUMBERS))
            has = formed.ranks.get(robot)
            if has == joined.rank:
                return []
            told = "it is no member" if has is None else f"its rank is {has}"
            why = f"takes rank {joined.rank} in epoch {epoch}, where {told}"
            return [broken("F4", robot, why, formed.by)]

        return check


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


def _of_driving(
    fence: FenceChanged,
    before: FenceChanged | None,
    formed: Formed | None,
    t_s: float,
    *,
    may_be_missing: bool,
) -> Iterator[str]:
    """Rules 1 and 2 for a fence ALL, the one before it in its epoch, and its formation."""
    told = f"turn {fence.turn} of epoch {fence.epoch} lets all move"
    if before is not None and before.may is not May.NOBODY:
        yield f"{told} right after a turn of robot {before.named}"
    if formed is None:
        if not may_be_missing:
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
