"""The rules of a fault plan: one type for each fault, with the fields of the file.

Rule 1: a rule is limited only by the fields that it sets.
Rule 2: every draw depends on the run's seed and the rule's name, so a rule never changes another's draws.
"""

from enum import StrEnum
from typing import Annotated, Literal

from msgspec import Meta, Struct, field

from protocol.frames import ROBOTS_MAX, Count, Seconds
from protocol.keys import WORLD

RULES_MAX = 1000  # of a plan
GIVEN_MAX = 100  # for messages, given by hand and active at once
ROUTER = "router"
ROBOT = r"r[1-9][0-9]{0,3}"  # robots have numbers up to 2000
ROLES = ("leader", "middle", "tail", "coordinator")


def _process(*others: str) -> Meta:
    """A robot or one of these; `words` and `names` are for refusals (`protocol.files.refusals`)."""
    words = f"a robot as r3, or {', '.join(others)}"
    return Meta(pattern=rf"^({'|'.join((ROBOT, *others))})$", extra={"words": words, "names": others})


Name = Annotated[
    str,
    Meta(pattern=r"^[A-Za-z0-9_.-]{1,64}$", extra={"words": "1 to 64 letters, digits, '_', '.' or '-'"}),
]
Process = Annotated[str, _process(WORLD)]
End = Annotated[str, _process(WORLD, ROUTER)]
Target = Annotated[str, _process(*ROLES, WORLD, ROUTER)]
Probability = Annotated[float, Meta(ge=0.0, le=1.0)]
SomeSeconds = Annotated[float, Meta(gt=0.0, le=1e4)]
MessageKind = Literal[
    "ahead",
    "answer",
    "ask",
    "behind",
    "drive",
    "formation",
    "log",
    "logged",
    "mission",
    "odometry",
    "plea",
    "raise",
    "report",
    "scan",
    "scan_query",
    "turn",
]


class StepPoint(StrEnum):
    """A named point in a robot's step at which a process fault can be injected."""

    AFTER_SCAN = "after_scan"  # it has received a scan and has not acted on it
    AFTER_PLAN = "after_plan"  # it has recorded a switching step and has sent no order
    MID_DRIVE = "mid_drive"  # its body has driven at least half of the ordered distance
    BEFORE_ACK = "before_ack"  # it knows new vertices of the path ahead and has not acknowledged them


class Burst(Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """Faults in bursts (Gilbert-Elliott model): each message of a key can begin or end a burst."""

    enter: Annotated[Probability, Meta(description="probability that a burst begins with a message")]
    leave: Annotated[Probability, Meta(description="probability that a burst ends with a message")]
    loss: Annotated[
        Probability, Meta(description="probability that the fault strikes a message within a burst")
    ]

    def __post_init__(self) -> None:
        if self.enter + self.leave > 1.0:  # such faults are single, not in bursts
            raise ValueError(f"enter + leave must be <= 1, got {self.enter} + {self.leave}")


class _Rule(Struct, frozen=True, kw_only=True, forbid_unknown_fields=True, tag_field="fault"):
    """The fields that all rules share."""

    name: Annotated[
        Name | None,
        Meta(description="its name in the timeline; default: its fault and its position in the file"),
    ] = None
    from_s: Annotated[Seconds, Meta(description="active from this time on")] = 0.0
    until_s: Annotated[Seconds | None, Meta(description="no longer active from this time on")] = None
    from_step: Annotated[
        Count, Meta(description="active once the leader has planned this switching step")
    ] = 0
    until_step: Annotated[
        Count | None, Meta(description="no longer active once the leader has planned this switching step")
    ] = None
    probability: Annotated[
        Probability, Meta(description="for each message; for a process fault: that the rule strikes at all")
    ] = 1.0

    def __post_init__(self) -> None:
        if self.until_s is not None and self.until_s <= self.from_s:
            raise ValueError(f"until_s must be > from_s = {self.from_s:g} s, got {self.until_s:g}")
        if self.until_step is not None and self.until_step <= self.from_step:
            raise ValueError(f"until_step must be > from_step = {self.from_step}, got {self.until_step}")

    @property
    def fault(self) -> str:
        """The name of the fault in the file."""
        return str(self.__struct_config__.tag)

    def holds(self, now_s: float, step: int) -> bool:
        """Whether the rule is active at this time and after so many switching steps."""
        return (
            self.from_s <= now_s
            and self.from_step <= step
            and (self.until_s is None or now_s < self.until_s)
            and (self.until_step is None or step < self.until_step)
        )


class _MessageRule(_Rule, frozen=True, kw_only=True):
    """The fields that the rules for messages share."""

    sender: Annotated[
        tuple[Process, ...],
        Meta(max_length=ROBOTS_MAX, description="only messages from these: `r3`, `world`; empty: any sender"),
    ] = field(default=(), name="from")
    receiver: Annotated[
        tuple[Process, ...],
        Meta(max_length=ROBOTS_MAX, description="only messages to these; empty: any receiver"),
    ] = field(default=(), name="to")
    kinds: Annotated[
        tuple[MessageKind, ...],
        Meta(description="only these kinds of message; empty: all but `log` and `logged`"),
    ] = field(default=(), name="kind")
    burst: Annotated[Burst | None, Meta(description="faults in bursts, instead of `probability`")] = None

    def __post_init__(self) -> None:
        super().__post_init__()
        if self.burst is not None and self.probability != 1.0:
            raise ValueError(f"a rule with a burst must have no probability, got {self.probability}")


class Drop(_MessageRule, frozen=True, kw_only=True, tag="drop"):
    """Messages are lost."""


class Delay(_MessageRule, frozen=True, kw_only=True, tag="delay"):
    """Messages arrive later. Each has its own delay, so messages can overtake each other."""

    delay_s_min: Annotated[Seconds, Meta(description="shortest delay")] = 0.0
    delay_s_max: Annotated[SomeSeconds, Meta(description="longest delay; delays are uniform between the two")]

    def __post_init__(self) -> None:
        super().__post_init__()
        if self.delay_s_min > self.delay_s_max:
            raise ValueError(
                f"delay_s_min must be <= delay_s_max = {self.delay_s_max:g} s, got {self.delay_s_min:g}"
            )


class Duplicate(_MessageRule, frozen=True, kw_only=True, tag="duplicate"):
    """Messages arrive again after a delay."""

    copies: Annotated[int, Meta(ge=1, le=100, description="number of additional copies")] = 1
    delay_s_max: Annotated[
        Seconds, Meta(description="longest delay of a copy; delays are uniform from 0")
    ] = 0.0


class Reorder(_MessageRule, frozen=True, kw_only=True, tag="reorder"):
    """Messages are held for a fixed time, so that later messages overtake them."""

    hold_s: Annotated[SomeSeconds, Meta(description="how long a message is held")]


class Corrupt(_MessageRule, frozen=True, kw_only=True, tag="corrupt"):
    """Messages arrive with flipped bits, or truncated."""

    bits: Annotated[int, Meta(ge=0, le=1000, description="number of bits to flip, at random positions")] = 1
    truncate: Annotated[bool, Meta(description="cut off at a random position, before bits are flipped")] = (
        False
    )

    def __post_init__(self) -> None:
        super().__post_init__()
        if self.bits == 0 and not self.truncate:
            raise ValueError("bits must be >= 1 where nothing is cut off, got 0")


class Partition(_MessageRule, frozen=True, kw_only=True, tag="partition"):
    """Two groups of processes cannot reach each other. A process cut off from the `router` reaches nobody."""

    group: Annotated[
        tuple[End, ...], Meta(min_length=1, max_length=ROBOTS_MAX, description="one side of the partition")
    ]
    others: Annotated[
        tuple[End, ...],
        Meta(
            max_length=ROBOTS_MAX,
            description="the other side; empty: all other processes, without the router",
        ),
    ] = ()
    one_way: Annotated[bool, Meta(description="only messages from `group` to `others` are lost")] = False
    period_s: Annotated[SomeSeconds | None, Meta(description="the partition repeats with this period")] = None
    cut_s: Annotated[
        SomeSeconds | None,
        Meta(description="how long the partition is active in each period, from its start"),
    ] = None

    def __post_init__(self) -> None:
        super().__post_init__()
        if both := [each for each in self.others if each in self.group]:
            raise ValueError(f"others must have no process of the group, got {', '.join(both)} in both")
        if (self.period_s is None) != (self.cut_s is None):
            raise ValueError("period_s and cut_s must be given together")
        if self.period_s is not None and self.cut_s is not None and self.cut_s > self.period_s:
            raise ValueError(f"cut_s must be <= period_s = {self.period_s:g} s, got {self.cut_s:g}")

    def holds(self, now_s: float, step: int) -> bool:
        """Whether the rule is active, and the partition is in the active part of its period."""
        if not super().holds(now_s, step):
            return False
        return self.period_s is None or (now_s - self.from_s) % self.period_s < (self.cut_s or 0.0)

    def cuts(self, sender: str, receiver: str) -> bool:
        """Whether the partition separates this sender from this receiver."""
        there = sender in self.group and self._is_other(receiver)
        back = receiver in self.group and self._is_other(sender)
        return there or (back and not self.one_way)

    def _is_other(self, process: str) -> bool:
        if self.others:
            return process in self.others
        return process not in self.group and process != ROUTER


class _ProcessRule(_Rule, frozen=True, kw_only=True):
    """The fields that the rules for processes share. Each rule strikes once, when all its conditions hold."""

    target: Annotated[
        Target,
        Meta(
            description="`r3`; the `leader`, `middle` or `tail` of the strand; a view's `coordinator`; "
            "`world`; `router`"
        ),
    ]
    robots: Annotated[
        int, Meta(ge=1, le=ROBOTS_MAX, description="number of robots: the target and those next behind it")
    ] = 1
    point: Annotated[StepPoint | None, Meta(description="strike at this point of the robot's step")] = None
    occurrence: Annotated[
        int, Meta(ge=1, le=2**53, description="strike when the robot reaches the point for the n-th time")
    ] = 1

    def __post_init__(self) -> None:
        super().__post_init__()
        if self.target in {WORLD, ROUTER} and (self.point is not None or self.robots > 1):
            raise ValueError(
                f"target must be a robot where there is a point or robots > 1, got {self.target}"
            )
        if self.robots > 1 and self.point is not None:
            raise ValueError(f"robots must be 1 where there is a point, got {self.robots}")
        if self.occurrence > 1 and self.point is None:
            raise ValueError(f"occurrence must be 1 where there is no point, got {self.occurrence}")


def _refuse_point(rule: _ProcessRule) -> None:
    """Refuse a point: only faults that stop a process can strike at a point."""
    if rule.point is not None:
        raise ValueError(f"point must not be given to {rule.fault}, got {rule.point}; from_step may be")


class Kill(_ProcessRule, frozen=True, kw_only=True, tag="kill"):
    """SIGKILL: the process ends; its body stays where it is."""


class Freeze(_ProcessRule, frozen=True, kw_only=True, tag="freeze"):
    """SIGSTOP: the process stops, and messages to it wait."""

    for_s: Annotated[
        SomeSeconds | None,
        Meta(description="it is thawed after this time; none: only a rule thaws it; required for the world"),
    ] = None

    def __post_init__(self) -> None:
        super().__post_init__()
        if self.target == WORLD and self.for_s is None:  # the world keeps the time and sends the thaws
            raise ValueError("for_s must be given where the world is frozen: nobody could thaw it")


class Thaw(_ProcessRule, frozen=True, kw_only=True, tag="thaw"):
    """SIGCONT: a frozen process continues where it stopped."""

    def __post_init__(self) -> None:
        super().__post_init__()
        if self.target == WORLD:
            raise ValueError(
                "target must not be the world, which cannot thaw itself: give its freeze a for_s"
            )
        _refuse_point(self)


class Restart(_ProcessRule, frozen=True, kw_only=True, tag="restart"):
    """SIGKILL, and later a new process for the same robot, which has no memory of the old one."""

    after_s: Annotated[Seconds, Meta(description="time until the new process starts")] = 0.0


class Slow(_ProcessRule, frozen=True, kw_only=True, tag="slow"):
    """The process reacts late to everything that arrives."""

    delay_s: Annotated[SomeSeconds, Meta(description="delay of each read of its inbox")]
    for_s: Annotated[SomeSeconds | None, Meta(description="the fault ends after this time; none: never")] = (
        None
    )

    def __post_init__(self) -> None:
        super().__post_init__()
        if self.target == ROUTER:
            raise ValueError("target must not be the router, which cannot be slowed")
        _refuse_point(self)


MessageRule = Drop | Delay | Duplicate | Reorder | Corrupt | Partition
ProcessRule = Kill | Freeze | Thaw | Restart | Slow
Rule = MessageRule | ProcessRule
