"""The rules of a fault plan: one type for each fault, as they stand in the file.

Rule 1: a rule names its limits; what it does not name does not limit it.
Rule 2: every draw is made of the run's seed and the rule's name, so a rule more or less changes no other.
"""

from enum import StrEnum
from typing import Annotated, Literal

from msgspec import Meta, Struct, field

from protocol.frames import ROBOTS_MAX, Count, Seconds

ROUTER = "router"
ROBOT = r"r[1-9][0-9]{0,3}"  # robots have numbers to 2000
Name = Annotated[str, Meta(pattern=r"^[A-Za-z0-9_.-]{1,64}$")]
Process = Annotated[str, Meta(pattern=rf"^({ROBOT}|world)$")]
End = Annotated[str, Meta(pattern=rf"^({ROBOT}|world|router)$")]
Target = Annotated[str, Meta(pattern=rf"^({ROBOT}|leader|middle|tail|world|router)$")]
Probability = Annotated[float, Meta(ge=0.0, le=1.0)]
SomeSeconds = Annotated[float, Meta(gt=0.0, le=1e4)]
MessageKind = Literal[
    "ahead",
    "ask",
    "beacon",
    "behind",
    "drive",
    "log",
    "logged",
    "mission",
    "muster",
    "odometry",
    "plea",
    "scan",
    "scan_query",
]


class StepPoint(StrEnum):
    """A named point in a robot's step, at which it can be struck exactly."""

    AFTER_SCAN = "after_scan"  # it has a scan, and has done nothing upon it
    AFTER_PLAN = "after_plan"  # it has recorded a switching step, and has given no order
    MID_DRIVE = "mid_drive"  # its body has done half of the way that was ordered, or more
    BEFORE_ACK = "before_ack"  # it knows new vertices of the path ahead, and has not said so


class Burst(Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """Faults in bursts (Gilbert-Elliott): each message of a key may begin or end one."""

    enter: Annotated[Probability, Meta(description="probability that a burst begins with a message")]
    leave: Annotated[Probability, Meta(description="probability that it is over with a message")]
    loss: Annotated[
        Probability, Meta(description="probability that the fault strikes a message within a burst")
    ]

    def __post_init__(self) -> None:
        if self.enter + self.leave > 1.0:  # such faults come one by one, not in bursts
            raise ValueError(f"enter + leave must be <= 1, got {self.enter} + {self.leave}")


class _Rule(Struct, frozen=True, kw_only=True, forbid_unknown_fields=True, tag_field="fault"):
    """What all rules share."""

    name: Annotated[
        Name | None,
        Meta(description="what the timeline calls the rule; else its fault and place in the file"),
    ] = None
    from_s: Annotated[Seconds, Meta(description="not before")] = 0.0
    until_s: Annotated[Seconds | None, Meta(description="not from then on")] = None
    from_step: Annotated[Count, Meta(description="not before the leader has planned this switching step")] = 0
    until_step: Annotated[Count | None, Meta(description="not once it has planned this one")] = None
    probability: Annotated[
        Probability, Meta(description="of each message, or of the whole rule where it strikes a process")
    ] = 1.0

    def __post_init__(self) -> None:
        if self.until_s is not None and self.until_s <= self.from_s:
            raise ValueError(f"until_s must be > from_s = {self.from_s:g} s, got {self.until_s:g}")
        if self.until_step is not None and self.until_step <= self.from_step:
            raise ValueError(f"until_step must be > from_step = {self.from_step}, got {self.until_step}")

    @property
    def fault(self) -> str:
        """What the file calls the fault."""
        return str(self.__struct_config__.tag)

    def holds(self, now_s: float, step: int) -> bool:
        """Whether the rule is in force at this time, and after so many switching steps."""
        return (
            self.from_s <= now_s
            and self.from_step <= step
            and (self.until_s is None or now_s < self.until_s)
            and (self.until_step is None or step < self.until_step)
        )


class _MessageRule(_Rule, frozen=True, kw_only=True):
    """What the rules for messages share."""

    sender: Annotated[
        tuple[Process, ...],
        Meta(max_length=ROBOTS_MAX, description="only what these say: `r3`, `world`; empty: anybody"),
    ] = field(default=(), name="from")
    receiver: Annotated[
        tuple[Process, ...], Meta(max_length=ROBOTS_MAX, description="only what these hear; empty: anybody")
    ] = field(default=(), name="to")
    kinds: Annotated[
        tuple[MessageKind, ...],
        Meta(description="only these kinds of message; empty: all but `log` and `logged`"),
    ] = field(default=(), name="kind")
    burst: Annotated[Burst | None, Meta(description="in bursts, instead of `probability`")] = None

    def __post_init__(self) -> None:
        super().__post_init__()
        if self.burst is not None and self.probability != 1.0:
            raise ValueError(f"a rule with a burst must have no probability, got {self.probability}")


class Drop(_MessageRule, frozen=True, kw_only=True, tag="drop"):
    """Messages are lost."""


class Delay(_MessageRule, frozen=True, kw_only=True, tag="delay"):
    """Messages arrive later, each after a time of its own, so they may overtake each other."""

    delay_s_min: Annotated[Seconds, Meta(description="at least")] = 0.0
    delay_s_max: Annotated[SomeSeconds, Meta(description="at most; all times between are alike")]

    def __post_init__(self) -> None:
        super().__post_init__()
        if self.delay_s_min > self.delay_s_max:
            raise ValueError(
                f"delay_s_min must be <= delay_s_max = {self.delay_s_max:g} s, got {self.delay_s_min:g}"
            )


class Duplicate(_MessageRule, frozen=True, kw_only=True, tag="duplicate"):
    """Messages arrive once more, after a while."""

    copies: Annotated[int, Meta(ge=1, le=100, description="how many more")] = 1
    delay_s_max: Annotated[Seconds, Meta(description="each at most so much later; all times are alike")] = 0.0


class Reorder(_MessageRule, frozen=True, kw_only=True, tag="reorder"):
    """Messages are held back for a fixed time, so that those sent after them overtake them."""

    hold_s: Annotated[SomeSeconds, Meta(description="how long")]


class Corrupt(_MessageRule, frozen=True, kw_only=True, tag="corrupt"):
    """Messages arrive with bits flipped, or cut off."""

    bits: Annotated[int, Meta(ge=0, le=1000, description="how many bits are flipped, anywhere")] = 1
    truncate: Annotated[bool, Meta(description="cut off anywhere, before bits are flipped")] = False

    def __post_init__(self) -> None:
        super().__post_init__()
        if self.bits == 0 and not self.truncate:
            raise ValueError("bits must be >= 1 where nothing is cut off, got 0")


class Partition(_MessageRule, frozen=True, kw_only=True, tag="partition"):
    """Two groups of processes do not hear each other; whoever is cut from the `router` hears nobody."""

    group: Annotated[tuple[End, ...], Meta(min_length=1, max_length=ROBOTS_MAX, description="one side")]
    others: Annotated[
        tuple[End, ...],
        Meta(max_length=ROBOTS_MAX, description="the other; empty: all processes but the router"),
    ] = ()
    one_way: Annotated[bool, Meta(description="only what `group` says to `others` is lost")] = False
    period_s: Annotated[SomeSeconds | None, Meta(description="comes and goes once in this time")] = None
    cut_s: Annotated[
        SomeSeconds | None, Meta(description="how much of each period is cut, from its start")
    ] = None

    def __post_init__(self) -> None:
        super().__post_init__()
        if (self.period_s is None) != (self.cut_s is None):
            raise ValueError("period_s and cut_s must be given together")
        if self.period_s is not None and self.cut_s is not None and self.cut_s > self.period_s:
            raise ValueError(f"cut_s must be <= period_s = {self.period_s:g} s, got {self.cut_s:g}")

    def holds(self, now_s: float, step: int) -> bool:
        """Whether the rule is in force, and the partition does not just let go for a while."""
        if not super().holds(now_s, step):
            return False
        return self.period_s is None or (now_s - self.from_s) % self.period_s < (self.cut_s or 0.0)

    def cuts(self, sender: str, receiver: str) -> bool:
        """Whether it lies between these two, on the way from the one to the other."""
        there = sender in self.group and self._is_other(receiver)
        back = receiver in self.group and self._is_other(sender)
        return there or (back and not self.one_way)

    def _is_other(self, process: str) -> bool:
        if self.others:
            return process in self.others
        return process not in self.group and process != ROUTER


class _ProcessRule(_Rule, frozen=True, kw_only=True):
    """What the rules for processes share. Each strikes once, as soon as all that it names holds."""

    target: Annotated[
        Target,
        Meta(description="`r3`, or who is `leader`, `middle` or `tail` of the strand; `world`; `router`"),
    ]
    robots: Annotated[
        int, Meta(ge=1, le=ROBOTS_MAX, description="how many: the target, and those next behind it")
    ] = 1
    point: Annotated[StepPoint | None, Meta(description="at this point of the robot's step")] = None
    occurrence: Annotated[int, Meta(ge=1, le=2**53, description="when it comes there for the n-th time")] = 1

    def __post_init__(self) -> None:
        super().__post_init__()
        if self.target in {"world", ROUTER} and (self.point is not None or self.robots > 1):
            raise ValueError(
                f"target must be a robot where there is a point or robots > 1, got {self.target}"
            )
        if self.robots > 1 and self.point is not None:
            raise ValueError(f"robots must be 1 where there is a point, got {self.robots}")


def _refuse_point(rule: _ProcessRule) -> None:
    """Only what stops a process can strike it exactly at a point."""
    if rule.point is not None:
        raise ValueError(f"point must not be given to {rule.fault}, got {rule.point}; from_step may be")


class Kill(_ProcessRule, frozen=True, kw_only=True, tag="kill"):
    """SIGKILL: the process is no more, and its body stays."""


class Freeze(_ProcessRule, frozen=True, kw_only=True, tag="freeze"):
    """SIGSTOP: the process does nothing, and what is sent to it waits."""

    for_s: Annotated[
        SomeSeconds | None,
        Meta(description="then it is thawed; none: unless a rule does; the world needs it"),
    ] = None

    def __post_init__(self) -> None:
        super().__post_init__()
        if self.target == "world" and self.for_s is None:  # it keeps the time, and tells who is to be thawed
            raise ValueError("for_s must be given where the world is frozen: nobody could thaw it")


class Thaw(_ProcessRule, frozen=True, kw_only=True, tag="thaw"):
    """SIGCONT: a frozen process goes on as if nothing had been."""

    def __post_init__(self) -> None:
        super().__post_init__()
        if self.target == "world":
            raise ValueError("target must not be the world, which cannot tell when: its freeze has for_s")
        _refuse_point(self)


class Restart(_ProcessRule, frozen=True, kw_only=True, tag="restart"):
    """SIGKILL, and later a new process in the same place, which remembers nothing."""

    after_s: Annotated[Seconds, Meta(description="how long there is none")] = 0.0


class Slow(_ProcessRule, frozen=True, kw_only=True, tag="slow"):
    """The process takes time over whatever it does."""

    delay_s: Annotated[SomeSeconds, Meta(description="for all that has arrived, each time that it looks")]
    for_s: Annotated[SomeSeconds | None, Meta(description="then it is as before; none: to the end")] = None

    def __post_init__(self) -> None:
        super().__post_init__()
        if self.target == ROUTER:
            raise ValueError("target must not be the router, which is not ours to slow")
        _refuse_point(self)


MessageRule = Drop | Delay | Duplicate | Reorder | Corrupt | Partition
ProcessRule = Kill | Freeze | Thaw | Restart | Slow
Rule = MessageRule | ProcessRule
