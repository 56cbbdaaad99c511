"""Cases that show again what others show, with other seeds, more robots or more loss."""

from collections.abc import Iterable

import pytest


def long(cases: Iterable[object]) -> list[object]:
    """These cases, of one argument or a tuple of several, for `launch/test.sh --long` only."""
    return [
        pytest.param(*(case if isinstance(case, tuple) else (case,)), marks=pytest.mark.long)
        for case in cases
    ]
