"""A fault plan: the faults to inject in a run, and when. Read from TOML; docs/faults.md."""

from collections.abc import Collection
from pathlib import Path
from typing import Annotated, Any

import msgspec
from msgspec import Meta, Struct, field
from msgspec.structs import force_setattr, replace

from protocol.errors import UsageError
from protocol.faults.rules import RULES_MAX, Delay, Drop, Duplicate, Name, Rule
from protocol.files.names import did_you_mean
from protocol.files.reading import read, understand
from protocol.root import LAUNCH

PLANS = LAUNCH / "faults"


class Plan(Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """Rules, in the order in which they decide about a message. A rule without a name gets one here."""

    name: Annotated[Name, Meta(description="the plan's name")]
    description: Annotated[str, Meta(max_length=2000, description="free text for readers")] = ""
    rules: Annotated[
        tuple[Rule, ...], Meta(max_length=RULES_MAX, description="the faults to inject, in order")
    ] = field(default=(), name="rule")

    def __post_init__(self) -> None:
        named = tuple(
            rule if rule.name is not None else replace(rule, name=f"{rule.fault}-{place}")
            for place, rule in enumerate(self.rules, start=1)
        )
        names = [rule.name for rule in named]
        if twice := sorted({str(name) for name in names if names.count(name) > 1}):
            raise ValueError(f"no two rules may have one name, got {', '.join(twice)} twice")
        force_setattr(self, "rules", named)  # so a rule keeps its name when the shrinker removes others

    @property
    def names(self) -> list[str]:
        """The names of its rules, in order."""
        return [str(rule.name) for rule in self.rules]


NO_FAULTS = Plan(name="none")


def uniform(*, loss: float = 0.0, delay_s_max: float = 0.0, repeat: float = 0.0) -> Plan:
    """A plan with the same loss, repetition and delay for all messages; delays are uniform from 0."""
    rules: list[Rule] = []
    if loss > 0.0:
        rules.append(Drop(probability=loss))
    if repeat > 0.0:
        rules.append(Duplicate(probability=repeat, delay_s_max=delay_s_max))
    if delay_s_max > 0.0:
        rules.append(Delay(delay_s_max=delay_s_max))
    return Plan(name="uniform", rules=tuple(rules))


def shipped() -> dict[str, Path]:
    """The files of the plans in launch/faults, by name."""
    return {kept.stem: kept for kept in sorted(PLANS.glob("*.toml"))}


def is_plan(said: dict[str, Any]) -> bool:
    """Whether this is the content of a fault plan, right or wrong, and of no scenario."""
    return "rule" in said and "fleet" not in said


def load(name_or_path: str, others: Collection[str] = ()) -> Plan:
    """Load the plan with that name in launch/faults, or from that .toml file; `none` is one without faults.

    Args:
        name_or_path: of the plan.
        others: what a user may also say here; a refusal names them.

    Raises:
        UsageError: it is a scenario, or wrong: one line names the file, the field, its bound and its value.
    """
    path = Path(name_or_path)
    if name_or_path == NO_FAULTS.name:
        return NO_FAULTS
    if path.suffix != ".toml":
        known = shipped()
        if name_or_path in {kept.stem for kept in (LAUNCH / "scenarios").rglob("*.toml")}:
            raise UsageError(f"{name_or_path!r} is a scenario, not a fault plan")
        if name_or_path not in known:
            names = [*known, *others]
            raise UsageError(
                f"unknown fault plan {name_or_path!r}: must be one of {', '.join(names)}, or a .toml file"
                f"{did_you_mean(name_or_path, names)}"
            )
        path = known[name_or_path]
    said = read(path, name_or_path)
    if "fleet" in said:
        raise UsageError(f"{name_or_path!r} is a scenario, not a fault plan")
    return understand(said, Plan, name_or_path)


def schema() -> dict[str, Any]:
    """The JSON Schema of fault plans, as kept in launch/faults for editors."""
    return msgspec.json.schema(Plan)
