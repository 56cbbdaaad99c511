"""The rules of fault plans as functions: each makes one rule, with the fields of docs/faults.md.

drop("ahead", p=0.3)                           # 30 % of these messages, from and to anybody
partition(["r1", "r2"], ["r3"], from_s=2.0, until_s=4.0)
kill("leader", at="after_plan", step=2)        # as soon as it has recorded its second step
"""

from collections.abc import Iterable, Mapping
from inspect import signature
from typing import Any, TypedDict, Unpack

from protocol.errors import UsageError
from protocol.faults.rules import Rule
from protocol.files.names import did_you_mean
from protocol.files.reading import understand
from protocol.files.refusals import short
from protocol.keys import not_of_fleet, robot_name, robot_number

Who = int | str | Iterable[int | str]
"""Processes: `3` or `"r3"` is a robot; `"world"`; or several of them."""


class When(TypedDict, total=False):
    """When a rule is active; all times are simulated."""

    from_s: float
    until_s: float
    step: int
    """Once the leader has planned this switching step."""
    until_step: int
    name: str
    """Its name in the timeline."""


class Which(When, total=False):
    """Which messages a rule is about, and when."""

    p: float
    """The probability for each message."""
    sender: Who
    receiver: Who


_FIELDS = {"step": "from_step", "p": "probability", "sender": "from", "receiver": "to"}
"""The words of fault plans where ours are shorter; `from` is a word of Python."""


def drop(*kinds: str, **which: Unpack[Which]) -> Rule:
    """Messages are lost.

    >>> drop("ahead", p=0.3).probability
    0.3
    """
    return _of_messages("drop", kinds, which)


def delay(*kinds: str, max_s: float, min_s: float = 0.0, **which: Unpack[Which]) -> Rule:
    """Messages arrive late, each by a random time from `min_s` to `max_s`."""
    return _of_messages("delay", kinds, which, delay_s_max=max_s, delay_s_min=min_s)


def duplicate(*kinds: str, copies: int = 1, max_s: float = 0.0, **which: Unpack[Which]) -> Rule:
    """Messages arrive again, each copy up to `max_s` later."""
    return _of_messages("duplicate", kinds, which, copies=copies, delay_s_max=max_s)


def reorder(*kinds: str, hold_s: float, **which: Unpack[Which]) -> Rule:
    """Messages are held for `hold_s`, so that later messages overtake them."""
    return _of_messages("reorder", kinds, which, hold_s=hold_s)


def corrupt(*kinds: str, bits: int = 1, truncate: bool = False, **which: Unpack[Which]) -> Rule:
    """Messages arrive with flipped bits, or cut off."""
    return _of_messages("corrupt", kinds, which, bits=bits, truncate=truncate)


def partition(group: Who, others: Who = (), *, one_way: bool = False, **which: Unpack[Which]) -> Rule:
    """Two groups of processes cannot reach each other; without `others`, the group and all the rest.

    >>> partition([1, 2], "r3").group
    ('r1', 'r2')
    """
    groups = {"group": names(group), "others": names(others)}
    return _of_messages("partition", (), which, one_way=one_way, **groups)


def kill(
    target: int | str, *, at: str | None = None, occurrence: int = 1, robots: int = 1, **when: Unpack[When]
) -> Rule:
    """SIGKILL to a robot, a role (`leader`, `middle`, `tail`, `coordinator`), the `world` or the `router`.

    Args:
        target: the process.
        at: the point of its step: `after_scan`, `after_plan`, `mid_drive` or `before_ack`.
        occurrence: which time it is there.
        robots: how many: the target and those next behind it.
        when: when the rule is active.
    """
    return _of_process("kill", target, when, point=at, occurrence=occurrence, robots=robots)


def freeze(
    target: int | str, *, for_s: float | None = None, at: str | None = None, **when: Unpack[When]
) -> Rule:
    """SIGSTOP; after `for_s`, SIGCONT."""
    return _of_process("freeze", target, when, for_s=for_s, point=at)


def thaw(target: int | str, **when: Unpack[When]) -> Rule:
    """SIGCONT to a process that is frozen."""
    return _of_process("thaw", target, when)


def restart(target: int | str, *, after_s: float = 0.0, at: str | None = None, **when: Unpack[When]) -> Rule:
    """SIGKILL, and `after_s` later a new process without any memory."""
    return _of_process("restart", target, when, after_s=after_s, point=at)


def slow(target: int | str, *, by_s: float, for_s: float | None = None, **when: Unpack[When]) -> Rule:
    """The process reacts `by_s` later to everything that arrives."""
    return _of_process("slow", target, when, delay_s=by_s, for_s=for_s)


def names(who: Who) -> tuple[str, ...]:
    """The names of these processes."""
    one_by_one = who if isinstance(who, Iterable) and not isinstance(who, str) else (who,)
    return tuple(robot_name(each) if isinstance(each, int) else each for each in one_by_one)


def ends_of(one: int | str, other: int | str) -> tuple[str, str]:
    """The names of the two ends of a link.

    Raises:
        UsageError: they are one: no message goes from a robot to itself.
    """
    first, second = names((one, other))
    if first == second:
        raise UsageError(f"link: must be between two robots, got {first} twice")
    return first, second


def robot_of(who: int | str, robots: int) -> int:
    """The number of a robot, `3` or `"r3"`, in a fleet of so many.

    Raises:
        UsageError: the fleet has no such robot.
    """
    number = robot_number(who) if isinstance(who, str) else who
    if number is None or number not in range(1, robots + 1):
        raise UsageError(f"robot: {not_of_fleet(who, robots)}")
    return int(number)


def _of_messages(fault: str, kinds: tuple[object, ...], which: Which, **fields: Any) -> Rule:  # noqa: ANN401 - fields of a rule have any type
    _check_known(fault, which, Which)
    for each in kinds:
        if isinstance(each, int | float) and "p" not in which:
            raise UsageError(f"clew.{fault}: kinds of message come first, got {each}; did you mean p={each}?")
    said: dict[str, Any] = {**which, **fields, "kind": kinds}
    for end in ("sender", "receiver"):
        if end in said:
            said[end] = names(said[end])
    return _rule(fault, said)


def _of_process(fault: str, target: int | str, when: When, **fields: Any) -> Rule:  # noqa: ANN401 - as above
    _check_known(fault, when, When)
    process = robot_name(target) if isinstance(target, int) else target
    return _rule(fault, {**when, "target": process, **fields})


def _check_known(fault: str, said: Mapping[str, object], common: type) -> None:
    """Refuse an argument that this function does not have, by our words and not by those of fault plans.

    Raises:
        UsageError: there is one.
    """
    parameters = signature(globals()[fault]).parameters.values()
    own = [each.name for each in parameters if each.kind is each.KEYWORD_ONLY]
    known = [*own, *common.__annotations__]
    for word in said.keys() - set(known):
        ours = [name for name, of_plans in _FIELDS.items() if of_plans.startswith(word) and name in known]
        near = f"; did you mean {ours[0]!r}?" if ours else did_you_mean(word, known)
        got = f"{word}={short(said[word])}"
        raise UsageError(f"clew.{fault}: must have no argument but {', '.join(known)}, got {got}{near}")


def _rule(fault: str, fields: Mapping[str, Any]) -> Rule:
    """The rule with these fields.

    Raises:
        UsageError: a field is wrong; one line names it, its bound and its value.
    """
    said = {_FIELDS.get(name, name): value for name, value in fields.items() if value is not None}
    return understand({"fault": fault, **said}, Rule, f"clew.{fault}")  # type: ignore[arg-type] # a union of types
