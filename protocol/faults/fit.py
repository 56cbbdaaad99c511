"""Checks a fault plan against a fleet: its rules may name only processes and messages that exist. Pure."""

from collections.abc import Iterator, Sequence

from protocol.errors import UsageError
from protocol.faults.plan import Plan
from protocol.faults.rules import MessageKind, MessageRule, Partition, ProcessRule, Rule
from protocol.keys import WORLD, not_of_fleet, robot_number

ROBOTS, ASKERS = "robots", "robots, whose name is not told"

WAYS: dict[MessageKind, tuple[str, str]] = {
    "ahead": (ROBOTS, ROBOTS),
    "answer": (ROBOTS, ROBOTS),
    "ask": (ASKERS, WORLD),
    "behind": (ROBOTS, ROBOTS),
    "drive": (ROBOTS, WORLD),
    "formation": (ROBOTS, ROBOTS),
    "log": (ROBOTS, WORLD),
    "logged": (WORLD, ROBOTS),
    "mission": (WORLD, ROBOTS),
    "odometry": (WORLD, ROBOTS),
    "plea": (ROBOTS, ROBOTS),
    "raise": (ROBOTS, WORLD),
    "report": (ROBOTS, ROBOTS),
    "scan": (WORLD, ROBOTS),
    "scan_query": (ROBOTS, WORLD),
    "turn": (ROBOTS, WORLD),
}
"""The sender and the receiver of each kind of message."""


def check_fits(plan: Plan, *, robots: int, source: str | None = None) -> None:
    """Refuse a plan that names robots that the fleet does not have, or messages that are never sent there.

    Args:
        plan: the plan.
        robots: how many robots the fleet has.
        source: names the plan in error messages, as its user did.

    Raises:
        UsageError: in one line: the plan, the path of the field, its bound, and its value.
    """
    for place, rule in enumerate(plan.rules):
        for misfit in misfits(rule, robots=robots):
            raise UsageError(f"{called(plan, source)}: $.rule[{place}]{misfit}")


def called(plan: Plan, source: str | None) -> str:
    """A plan in a refusal: as its user named it, or by its own name."""
    return source or f"fault plan {plan.name}"


def misfits(rule: Rule, *, robots: int) -> Iterator[str]:
    """The fields of a rule that do not fit a fleet: the path of each, its bound, and its value."""
    for path, name in _names(rule):
        number = robot_number(name)
        if number is not None and number > robots:
            yield f"{path}: {not_of_fleet(name, robots)}"
    if isinstance(rule, ProcessRule) and rule.robots > robots:
        yield f".robots: must be <= {robots}, the fleet's, got {rule.robots}"
    if isinstance(rule, MessageRule):
        yield from _never_sent(rule)


def _never_sent(rule: MessageRule) -> Iterator[str]:
    """The fields of a rule by which no message can match it."""
    if rule.sender and rule.receiver and len({*rule.sender, *rule.receiver}) == 1:
        yield f".to: must name another process than `from`, got {rule.receiver[0]}, and none sends to itself"
    if rule.kinds and not any(_may_go(rule, kind) for kind in rule.kinds):
        said = (f"{kind}, which goes from {WAYS[kind][0]} to {WAYS[kind][1]}" for kind in rule.kinds)
        yield f".kind: must be a message from one of `from` to one of `to`, got {'; '.join(said)}"


def _names(rule: Rule) -> Iterator[tuple[str, str]]:
    """The processes that a rule names, each with its field's path."""
    if isinstance(rule, ProcessRule):
        yield ".target", rule.target
        return
    lists = {"from": rule.sender, "to": rule.receiver}
    if isinstance(rule, Partition):
        lists |= {"group": rule.group, "others": rule.others}
    for field, names in lists.items():
        yield from ((f".{field}[{place}]", name) for place, name in enumerate(names))


def _may_go(rule: MessageRule, kind: MessageKind) -> bool:
    """Whether a kind of message can go from a sender of the rule to a receiver of the rule."""
    sender, receiver = WAYS[kind]
    return _may_be(sender, rule.sender) and _may_be(receiver, rule.receiver)


def _may_be(end: str, named: Sequence[str]) -> bool:
    """Whether a named process can be at this end of a kind of message; no names mean any process."""
    if not named:
        return True
    return end != ASKERS and any((name == WORLD) == (end == WORLD) for name in named)
