"""The tables of `docs/faults.md`, from the types of a fault plan."""

from collections.abc import Mapping
from typing import Any, get_args

from clew.manual.tables import Schema, table
from protocol.faults.plan import PLANS, load, schema
from protocol.faults.rules import MessageRule, ProcessRule


def rules() -> str:
    """The file, each rule and the shipped plans."""
    components = schema()["$defs"]
    messages, processes = (
        [components[kind.__name__] for kind in get_args(rules)] for rules in (MessageRule, ProcessRule)
    )
    shared = _shared([*messages, *processes])
    for_messages, for_processes = _shared(messages), _shared(processes)
    return "\n".join(
        [
            "## The file\n",
            _table(_fields(components["Plan"]), components),
            "## `[[rule]]`\n",
            "Every rule has a `fault`. Its optional fields:\n",
            _table(shared, components),
            "### Faults of messages\n",
            "Further fields:\n",
            _table(_without(for_messages, shared), components),
            _kinds(messages, for_messages, components),
            "### Faults of processes\n",
            "Each rule strikes once, as soon as all its conditions hold. Further fields:\n",
            _table(_without(for_processes, shared), components),
            _kinds(processes, for_processes, components),
            "### Burst\n",
            f"{components['Burst']['description']}\n",
            _table(_fields(components["Burst"]), components),
            "## The plans in `launch/faults/`\n",
            _plans(),
        ]
    )


def _kinds(rules: list[Schema], known: Mapping[str, Schema], components: Schema) -> str:
    """Each fault with the fields that only it has."""
    sections = []
    for rule in rules:
        fault = rule["properties"]["fault"]["enum"][0]
        own = _without(_fields(rule), known)
        more = f"\n{_table(own, components)}" if own else ""
        sections.append(f"#### `{fault}`\n\n{rule['description']}\n{more}")
    return "\n".join(sections)


def _plans() -> str:
    plans = [load(path.stem) for path in sorted(PLANS.glob("*.toml"))]
    rows = [f"| `{plan.name}` | {plan.description} |" for plan in plans]
    return "\n".join(["| plan | faults |", "|---|---|", *rows, ""])


def _fields(described: Schema) -> dict[str, Any]:
    return {name: field for name, field in described["properties"].items() if name != "fault"}


def _shared(rules: list[Schema]) -> dict[str, Any]:
    """The fields that all of them have."""
    first, *others = map(_fields, rules)
    return {name: field for name, field in first.items() if all(name in other for other in others)}


def _without(fields: Mapping[str, Schema], known: Mapping[str, Schema]) -> dict[str, Schema]:
    return {name: field for name, field in fields.items() if name not in known}


def _table(fields: Mapping[str, Schema], components: Schema) -> str:
    flat = {name: _flat(field) for name, field in fields.items()}
    return table(flat, components, defaults=True)


def _flat(field: Schema) -> Schema:
    """A list of rules as a list of one type: what a rule may be has tables of its own."""
    return {**field, "items": {"type": "rule"}} if "anyOf" in field.get("items", {}) else field
