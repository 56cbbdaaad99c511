"""Deaths, successions and heals of a run, each with the times of its cause, detection and recovery.

Rule 1: the timeline is the only input. Its sources have no common order, so entries are sorted by time first.
Rule 2: the cause of a death is an injected process fault or, if there is none, the last sign of life.
Rule 3: the detection is the first broken link to the dead robot or, if there is none, the first view that was
        proposed because a robot was lost.
Rule 4: the cause of a heal without a death is the return of a process or, if there is none, a silent link.
        Its detection is the first broken link since the last heal or, if there is none, the first view that
        was proposed for a reason that changes who is in the strand.
"""

from collections.abc import Iterator, Sequence

from msgspec import Struct
from msgspec.structs import replace

from protocol.fence import Cause
from protocol.keys import WORLD, robot_name, robot_number
from protocol.timeline import (
    FaultInjected,
    LeaderSucceeded,
    LinkBroken,
    Record,
    RobotDied,
    RobotRestarted,
    RobotReturned,
    StrandFormed,
    StrandHealed,
    ViewProposed,
)

KILLED = "kill"
ORDERED = (KILLED, "freeze")  # faults that make a death a requested one
THAWED = "thaw"
LOSSES = frozenset({Cause.NEIGHBOUR_LOST, Cause.COORDINATOR_LOST})
CHANGES = LOSSES | {Cause.PLEA, Cause.OUTSIDERS, Cause.MISFIT, Cause.WORLD_RESTARTED}
"""The causes of views that robots leave or enter; others keep the members."""

Dated = tuple[float, str, Record]
"""Time, source, record."""


class Death(Struct, frozen=True, kw_only=True):
    """A robot that died, or was considered dead because it was frozen or cut off."""

    robot: int
    ordered: bool
    """Whether a fault plan or `clew fault` caused it."""
    cause_s: float
    detected_s: float | None
    """When a robot detected it."""
    known_s: float
    """When the world detected it."""
    recovered_s: float | None
    """When a strand had healed after it."""
    returned_s: float | None
    """When the same process returned: it had been cut off or frozen."""


class Succession(Struct, frozen=True, kw_only=True):
    """A robot that leads instead of another."""

    robot: int
    before: int | None
    """The former leader."""
    epoch: int
    cause_s: float | None
    """Null: nothing is known to have happened to the former leader."""
    detected_s: float | None
    recovered_s: float


class Heal(Struct, frozen=True, kw_only=True):
    """A strand that formed again from the surviving robots."""

    epoch: int
    members: tuple[int, ...]
    """Leader first; none, if the formation was not recorded."""
    cause_s: float | None
    detected_s: float | None
    recovered_s: float


class Recovery:
    """All deaths, successions and heals, in order of time."""

    def __init__(self, dated: Sequence[Dated]) -> None:
        self._dated = sorted(dated, key=lambda each: each[0])
        self.deaths = tuple(self._deaths())
        self.successions = tuple(self._successions())
        self.heals = tuple(self._heals())

    @property
    def unrequested(self) -> Iterator[Death]:
        """Deaths without a request, of processes that never returned."""
        return (death for death in self.deaths if not death.ordered and death.returned_s is None)

    def _deaths(self) -> Iterator[Death]:
        told: dict[int, float] = {}  # by robot: faults up to this time belong to an earlier death
        for known_s, _, record in self._dated:
            if not isinstance(record, RobotDied):
                continue
            robot = record.robot
            struck_s = self._struck_s(robot, told.get(robot, -1.0), known_s)
            cause_s = record.silent_since_s if struck_s is None else struck_s
            told[robot] = known_s
            yield Death(
                robot=robot,
                ordered=struck_s is not None,
                cause_s=cause_s,
                detected_s=self._detected_s(robot, cause_s),
                known_s=known_s,
                recovered_s=self._healed_s(cause_s),
                returned_s=self._returned_s(robot, known_s),
            )

    def _struck_s(self, robot: int, after_s: float, until_s: float) -> float | None:
        """The time of the last fault of its process in that period: a kill, or a freeze without a thaw."""
        struck = [
            (t_s, record.fault)
            for t_s, _, record in self._dated
            if isinstance(record, FaultInjected)
            and record.process == robot_name(robot)
            and record.fault in (*ORDERED, THAWED)
            and after_s < t_s <= until_s
        ]
        thawed = bool(struck) and struck[-1][1] == THAWED  # as a dead process may be, too
        lasting = [t_s for t_s, fault in struck if fault == KILLED or not thawed]
        return lasting[-1] if lasting else None

    def _returned_s(self, robot: int, known_s: float) -> float | None:
        """When the same process returned; a restarted one is another process."""
        back = (
            (t_s, record)
            for t_s, _, record in self._dated
            if isinstance(record, RobotReturned | RobotRestarted) and record.robot == robot and t_s >= known_s
        )
        at_s, first = next(back, (None, None))
        return at_s if isinstance(first, RobotReturned) else None

    def _detected_s(self, robot: int, cause_s: float) -> float | None:
        broken = (
            t_s
            for t_s, _, record in self._dated
            if isinstance(record, LinkBroken) and record.neighbour == robot and t_s >= cause_s
        )
        lost = (t_s for t_s, about in self._proposed(LOSSES) if about in {robot, None} and t_s >= cause_s)
        return next(broken, next(lost, None))

    def _healed_s(self, from_s: float) -> float | None:
        """When a strand first healed from then on."""
        healed = (t_s for t_s, _, record in self._dated if isinstance(record, StrandHealed) and t_s >= from_s)
        return next(healed, None)

    def _proposed(self, causes: frozenset[Cause]) -> Iterator[tuple[float, int | None]]:
        """When views were proposed for such causes, and about which robot."""
        for t_s, _, record in self._dated:
            if isinstance(record, ViewProposed) and record.cause in causes:
                yield t_s, record.about

    def _successions(self) -> Iterator[Succession]:
        for t_s, source, record in self._dated:
            robot = robot_number(source)
            if not isinstance(record, LeaderSucceeded) or robot is None:
                continue
            causes = [death for death in self.deaths if death.robot == record.before and death.cause_s <= t_s]
            yield Succession(
                robot=robot,
                before=record.before,
                epoch=record.epoch,
                cause_s=causes[-1].cause_s if causes else None,
                detected_s=causes[-1].detected_s if causes else None,
                recovered_s=t_s,
            )

    def _returns_s(self, after_s: float, until_s: float) -> list[float]:
        """The times when processes returned in that period."""
        kinds = (RobotRestarted, RobotReturned)
        return [
            t_s for t_s, _, record in self._dated if isinstance(record, kinds) and after_s < t_s <= until_s
        ]

    def _heals(self) -> Iterator[Heal]:
        healed_s = -1.0
        orders = {each.epoch: each.order for _, _, each in self._dated if isinstance(each, StrandFormed)}
        for t_s, _, record in self._dated:
            if not isinstance(record, StrandHealed):
                continue
            broken = [
                (at_s, each)
                for at_s, _, each in self._dated
                if isinstance(each, LinkBroken) and healed_s < at_s <= t_s
            ]
            causes = (
                [death.cause_s for death in self.deaths if healed_s < death.cause_s <= t_s]
                or self._returns_s(healed_s, t_s)
                or [at_s - each.silent_s for at_s, each in broken]
            )
            detected = [at_s for at_s, _ in broken] or [
                at_s for at_s, _ in self._proposed(CHANGES) if healed_s < at_s <= t_s
            ]
            yield Heal(
                epoch=record.epoch,
                members=orders.get(record.epoch, ()),
                cause_s=min(causes, default=None),
                detected_s=min(detected, default=None),
                recovered_s=t_s,
            )
            healed_s = t_s


def summary(record: Record) -> Record:
    """What recovery needs of an entry: of a formation its order alone, not its places and its path."""
    if isinstance(record, StrandFormed):
        return replace(record, lives=(), places_m=(), laid=(), driven=())
    return record


def is_relevant(source: str, record: Record) -> bool:
    """Whether an entry is relevant for recovery."""
    match record:
        case FaultInjected(process=process):
            return process is not None  # not faults of messages: these are many
        case RobotDied() | RobotRestarted() | RobotReturned():
            return source == WORLD
        case LinkBroken() | ViewProposed() | StrandFormed() | LeaderSucceeded() | StrandHealed():
            return True
        case _:
            return False
