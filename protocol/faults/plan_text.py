"""A fault plan as its file says it; what goes without saying is left out. Pure."""

from typing import Any

import msgspec
from msgspec.structs import fields

from protocol.faults.plan import Plan
from protocol.faults.rules import Rule
from protocol.files.toml_text import toml_text

FAULTS_FILE = "faults.toml"


def plan_text(plan: Plan) -> str:
    """The plan as TOML; read again it is equal."""
    return toml_text(msgspec.to_builtins(plan) | {"rule": [_said(rule) for rule in plan.rules]})


def _said(rule: Rule) -> dict[str, Any]:
    """What a rule says beyond what goes without saying."""
    unsaid = {field.encode_name: field.default for field in fields(rule)}
    said = {"fault": rule.fault, **msgspec.to_builtins(rule)}
    return {key: value for key, value in said.items() if key not in unsaid or _differs(value, unsaid[key])}


def _differs(value: object, default: object) -> bool:
    return (tuple(value) if isinstance(value, list) else value) != default
