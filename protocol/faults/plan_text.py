"""Writes a fault plan as TOML, one table a rule; fields with default values are left out. Pure."""

from typing import Any

import msgspec
from msgspec.structs import fields

from protocol.faults.plan import Plan
from protocol.faults.rules import Rule
from protocol.files.toml_text import toml_text

FAULTS_FILE = "faults.toml"


def plan_text(plan: Plan) -> str:
    """The plan as TOML; a plan read from it is equal."""
    head = {key: value for key, value in msgspec.to_builtins(plan).items() if key != "rule"}
    return "\n".join([toml_text(head), *map(_table, plan.rules)])


def _table(rule: Rule) -> str:
    """A rule as an element of the list; `tomli-w` would write short ones into one line."""
    return toml_text({"rule": _set_fields(rule)}).replace("[rule]", "[[rule]]", 1)


def _set_fields(rule: Rule) -> dict[str, Any]:
    """The fields of a rule that differ from their defaults."""
    defaults = {field.encode_name: field.default for field in fields(rule)}
    values = {"fault": rule.fault, **msgspec.to_builtins(rule)}
    return {
        key: value for key, value in values.items() if key not in defaults or _differs(value, defaults[key])
    }


def _differs(value: object, default: object) -> bool:
    return (tuple(value) if isinstance(value, list) else value) != default
