"""Writes plain data as TOML, by `tomli-w`. Pure.

Rule 1: data that is read back is equal, floats to the last bit.
Rule 2: None values are left out, since TOML has no word for them.
"""

from collections.abc import Mapping, Sequence
from typing import Any

import tomli_w

Table = Mapping[str, Any]


def toml_text(table: Table) -> str:
    """The table as TOML."""
    return tomli_w.dumps({key: _said(each) for key, each in table.items() if each is not None})


def _said(value: object) -> object:
    """The same without what is None, in the types that `tomli-w` takes."""
    if isinstance(value, Mapping):
        return {key: _said(each) for key, each in value.items() if each is not None}
    if isinstance(value, Sequence) and not isinstance(value, str):
        return [_said(each) for each in value]
    return value
