"""A fault plan: what goes wrong in a run, and when. Read from TOML; docs/faults.md."""

from pathlib import Path
from typing import Annotated, Any

import msgspec
from msgspec import Meta, Struct, field
from msgspec.structs import force_setattr, replace

from protocol.errors import UsageError
from protocol.faults.rules import Delay, Drop, Duplicate, Name, Rule
from protocol.files.reading import read, understand
from protocol.root import ROOT

PLANS = ROOT / "launch" / "faults"


class Plan(Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """Rules, in the order in which they decide on a message. Each has a name, said or given."""

    name: Annotated[Name, Meta(description="what people call it")]
    description: Annotated[str, Meta(max_length=2000, description="for people")] = ""
    rules: Annotated[tuple[Rule, ...], Meta(max_length=1000, description="what goes wrong")] = field(
        default=(), name="rule"
    )

    def __post_init__(self) -> None:
        named = tuple(
            rule if rule.name is not None else replace(rule, name=f"{rule.fault}-{place}")
            for place, rule in enumerate(self.rules, start=1)
        )
        names = [rule.name for rule in named]
        if twice := sorted({str(name) for name in names if names.count(name) > 1}):
            raise ValueError(f"no two rules may have one name, got {', '.join(twice)} twice")
        force_setattr(self, "rules", named)  # names stay when the shrinker leaves other rules out

    @property
    def names(self) -> list[str]:
        """What its rules are called, in their order."""
        return [str(rule.name) for rule in self.rules]


NO_FAULTS = Plan(name="none")


def uniform(*, loss: float = 0.0, delay_s_max: float = 0.0, repeat: float = 0.0) -> Plan:
    """A plan that treats all messages alike: loss and repetition by probability, and any delay up to one."""
    rules: list[Rule] = []
    if loss > 0.0:
        rules.append(Drop(probability=loss))
    if repeat > 0.0:
        rules.append(Duplicate(probability=repeat, delay_s_max=delay_s_max))
    if delay_s_max > 0.0:
        rules.append(Delay(delay_s_max=delay_s_max))
    return Plan(name="uniform", rules=tuple(rules))


def load(name_or_path: str) -> Plan:
    """The plan of that name in launch/faults, or in that .toml file.

    Raises:
        UsageError: whatever is wrong, in one line: the file, the field, what it must be, what it says.
    """
    path = Path(name_or_path)
    if path.suffix != ".toml":
        known = {kept.stem: kept for kept in sorted(PLANS.glob("*.toml"))}
        if name_or_path not in known:
            raise UsageError(
                f"unknown fault plan {name_or_path!r}: must be one of {', '.join(known)}, or a .toml file"
            )
        path = known[name_or_path]
    return understand(read(path, name_or_path), Plan, name_or_path)


def schema() -> dict[str, Any]:
    """The JSON Schema of fault plans, as kept in launch/faults for editors."""
    return msgspec.json.schema(Plan)
