"""The invariants of every run besides S1 and S2, under any loss, delay, damage, kill or freeze.

They are judged from the timeline alone, in one place for live runs, rehearsals and logs.
S3: `motion`, `watched` and, while robots join, `authority`.
F1 to F6: the rules of fences (docs/strand.md), as far as a timeline shows them. `fences` judges the fences,
    `formations` what the coordinator made, `authority` the orders, and `motion` the bodies. This file has:
    F2: no robot plans or grants in an epoch that is not in force yet.
    F5: ground is granted only under ALL, by a member to the robot directly behind it, and never taken back.
P1: only the first robot of a formation leads it: only that robot plans steps and records that it leads.
P2: epochs never decrease in the entries of one process of a robot, nor time in those of the world: all
    motion is judged in the order of time.
P3: there is no ring, and each robot has one robot ahead: `formations`.
P4: stale or forged messages have no effect: no robot joins or leaves a view before its epoch is in force.
P5: queues are bounded and long enough: no inbox or outbox overflows, and entry numbers have no gaps.
P6: no core fails.
`world.judge.truth` holds what robots record against true poses: S4, A1, A2, and for who may record it P1, P7.
"""

from collections import defaultdict
from collections.abc import Iterator

from protocol.fence import NUMBERS
from protocol.keys import WORLD, robot_name, robot_number
from protocol.timeline import (
    AuthorityGranted,
    Entry,
    LeaderSucceeded,
    PromiseBroken,
    RobotFailed,
    RobotStarted,
    StepPlanned,
    StrandHealed,
    StrandJoined,
    TrafficCounted,
    ViewJoined,
    ViewLeft,
)
from world.judge.rules.claims import ROUNDING_S, Check, Claim, Claims
from world.judge.rules.evidence import ROUNDING_M, Evidence
from world.judge.rules.rule import Dated, breach_of, broken

ARRIVAL = ("A1", "A2")
"""What an arrival must keep to be one."""

EPOCHS_KEPT = 4  # of a link: its robots are in one epoch, and late entries are of the one before


class Leading:
    """P1."""

    kinds = frozenset[type]({LeaderSucceeded, StepPlanned, StrandHealed})

    def __init__(self, evidence: Evidence, claims: Claims) -> None:
        self._evidence = evidence
        self._claims = claims
        self._judged: dict[tuple[int, str], int] = {}
        """By robot and what it does: the newest epoch in which that was judged. Once for each is enough."""

    def hear(self, source: str, entry: Entry) -> Iterator[Dated]:
        """Process an entry that only a leader may record."""
        robot, record = robot_number(source), entry.record
        if robot is None or not isinstance(record, LeaderSucceeded | StepPlanned | StrandHealed):
            return
        if isinstance(record, StepPlanned) and record.joins:
            return
        does = "plans steps" if isinstance(record, StepPlanned) else "says that it leads"
        if self._judged.get((robot, does)) != record.epoch:
            self._judged[robot, does] = record.epoch
            yield from self._claims.judge(entry.t_s, record.epoch, self._leads(robot, record.epoch, does))

    def close(self) -> Iterator[Dated]:
        """Nothing is open but claims."""
        return iter(())

    def _leads(self, robot: int, epoch: int, does: str) -> Check:
        def check(claim: Claim) -> list[PromiseBroken] | frozenset[str]:
            formed = self._evidence.formed.get(epoch)
            if formed is None:
                return claim.awaiting(robot_name(epoch % NUMBERS))
            first = formed.strand.order[0]
            why = f"{does} in epoch {epoch}, which another leads"
            return [] if first == robot else [broken("P1", robot, why, first)]

        return check


class Granting:
    """F5 for grants."""

    kinds = frozenset[type]({AuthorityGranted})

    def __init__(self, evidence: Evidence, claims: Claims) -> None:
        self._evidence = evidence
        self._claims = claims
        self._granted_m: defaultdict[tuple[int, int], dict[int, float]] = defaultdict(dict)
        """By granter and grantee: the largest grant in each of the newest epochs."""
        self._lawful: dict[tuple[int, int], int] = {}
        """Likewise: the newest epoch in which a grant was lawful. Later ones in it are, too."""

    def hear(self, source: str, entry: Entry) -> Iterator[Dated]:
        """Process a grant."""
        robot, grant = robot_number(source), entry.record
        if robot is None or not isinstance(grant, AuthorityGranted):
            return
        link = robot, grant.to
        if self._lawful.get(link) != grant.epoch:
            yield from self._claims.judge(entry.t_s, grant.epoch, self._may_grant(robot, grant))
        granted_m = self._granted_m[link]
        most_m = granted_m.get(grant.epoch, 0.0)
        if grant.authority_m < most_m - ROUNDING_M:
            why = f"takes back what it has granted robot {grant.to}"
            yield entry.t_s, breach_of("F5", robot, grant.authority_m, most_m, why, other=grant.to)
        granted_m[grant.epoch] = max(most_m, grant.authority_m)
        if len(granted_m) > EPOCHS_KEPT:
            del granted_m[min(granted_m)]

    def close(self) -> Iterator[Dated]:
        """Nothing is open but claims."""
        return iter(())

    def _may_grant(self, robot: int, grant: AuthorityGranted) -> Check:
        epoch, in_epoch, fences = grant.epoch, f"in epoch {grant.epoch}", self._evidence.fences

        def check(claim: Claim) -> list[PromiseBroken] | frozenset[str]:
            driven, formed = fences.all_of(epoch), self._evidence.formed.get(epoch)
            if driven is None or fences.times_s[driven] > claim.t_s + ROUNDING_S:
                why = f"grants ground {in_epoch} before its strand may drive"
                return frozenset({WORLD}) if claim.may_hear(WORLD) else [broken("F5", robot, why, grant.to)]
            if formed is None:
                return claim.awaiting(robot_name(epoch % NUMBERS))
            if not formed.is_behind(grant.to, robot):
                why = f"grants ground {in_epoch} to a robot that is not directly behind it"
                return [broken("F5", robot, why, grant.to)]
            self._lawful[robot, grant.to] = epoch
            return []

        return check


class Epochs:
    """P2, and F2 and P4 for what robots record: nobody acts in an epoch that is not in force yet."""

    kinds = frozenset[type]({AuthorityGranted, RobotStarted, StepPlanned, StrandJoined, ViewJoined, ViewLeft})

    def __init__(self, evidence: Evidence, claims: Claims) -> None:
        self._evidence = evidence
        self._claims = claims
        self._newest: dict[int, int] = {}
        """By robot: the newest epoch that its process has recorded."""

    def hear(self, source: str, entry: Entry) -> Iterator[Dated]:
        """Process an entry with an epoch."""
        robot = robot_number(source)
        if robot is None:
            return
        match entry.record:
            case RobotStarted():
                self._newest.pop(robot, None)
            case StepPlanned(epoch=epoch) | AuthorityGranted(epoch=epoch):
                why = f"plans or grants in epoch {epoch}, which is not in force"
                yield from self._in_force(entry.t_s, robot, epoch, "F2", why)
                yield from self._in_order(entry.t_s, robot, epoch)
            case ViewJoined(epoch=epoch) | ViewLeft(epoch=epoch):
                why = f"joins or leaves the view of epoch {epoch}, which is not in force"
                yield from self._in_force(entry.t_s, robot, epoch, "P4", why)
                yield from self._in_order(entry.t_s, robot, epoch)
            case StrandJoined(epoch=epoch):
                yield from self._in_order(entry.t_s, robot, epoch)
            case _:
                pass  # has no epoch, or tells of a strand as a whole

    def close(self) -> Iterator[Dated]:
        """Nothing is open but claims."""
        return iter(())

    def _in_order(self, t_s: float, robot: int, epoch: int) -> Iterator[Dated]:
        newest = self._newest.get(robot, -1)
        if epoch < newest:
            yield t_s, broken("P2", robot, f"goes from epoch {newest} to {epoch}")
        self._newest[robot] = max(newest, epoch)

    def _in_force(self, t_s: float, robot: int, epoch: int, invariant: str, why: str) -> Iterator[Dated]:
        def check(claim: Claim) -> list[PromiseBroken] | frozenset[str]:
            if self._evidence.fences.begun_s(epoch) <= claim.t_s + ROUNDING_S:
                return []
            return frozenset({WORLD}) if claim.may_hear(WORLD) else [broken(invariant, robot, why)]

        return self._claims.judge(t_s, epoch, check)


class Counting:
    """P5 and P6."""

    kinds = frozenset[type]({RobotFailed, TrafficCounted})

    def hear(self, source: str, entry: Entry) -> Iterator[Dated]:
        """Process an entry about the process itself."""
        robot = robot_number(source)
        if robot is None:
            return
        match entry.record:
            case TrafficCounted(overflowed=overflowed, unrecorded=unrecorded) if overflowed or unrecorded:
                why = f"dropped {overflowed} arrivals and {unrecorded} entries: its queues were full"
                yield entry.t_s, broken("P5", robot, why)
            case RobotFailed(reason=reason):
                yield entry.t_s, broken("P6", robot, reason)
            case _:
                pass  # no violation

    def close(self) -> Iterator[Dated]:
        """Nothing is open."""
        return iter(())


class Numbers:
    """P5: the numbers of a process's entries have no gaps; P2: the world's time. It hears every entry."""

    def __init__(self) -> None:
        self._counts: dict[str, int] = {}
        self._newest_s = 0.0

    def hear(self, source: str, entry: Entry) -> Iterator[Dated]:
        """Compare number and time to those before; a new process counts from 1."""
        before, self._counts[source] = self._counts.get(source, 0), entry.n
        if source == WORLD:
            if entry.t_s < self._newest_s - ROUNDING_S:
                # A violation names a robot; what concerns all is counted for the first.
                yield entry.t_s, broken("P2", 1, f"the world's time goes back from {self._newest_s:.3f} s")
            self._newest_s = entry.t_s
        if entry.n in {before + 1, 1} or (robot := robot_number(source)) is None:
            return
        yield entry.t_s, broken("P5", robot, f"its entries go on with number {entry.n}")
