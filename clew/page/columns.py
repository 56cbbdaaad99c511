"""Columns: numbers for the page, rounded to a unit, each as the difference to the one before."""

from collections.abc import Sequence
from typing import Any

import numpy as np
from msgspec import Struct
from msgspec.structs import asdict
from numpy.typing import ArrayLike

from clew.page.batch import Column
from protocol.frames import Point

MS, MM, MRAD, TENTH_MM = 1e3, 1e3, 1e3, 1e4

DECIMALS = 6  # two more than are ever printed: rounding twice may change the last digit


def column(values: ArrayLike, per_unit: float) -> Column:
    """Numbers as integers of a unit, each as the difference to the one before."""
    whole = np.rint(np.asarray(values, dtype=np.float64) * per_unit).astype(np.int64)
    deltas: Column = np.diff(whole, prepend=0).tolist()
    return deltas


def plain(values: Sequence[Any]) -> list[Any]:
    """The values of one field of many records, with short numbers, and places as pairs."""
    if isinstance(values[0], float):  # a None becomes NaN, which JSON writes as null
        rounded: list[Any] = np.round(np.array(values, dtype=np.float64), DECIMALS).tolist()
        return rounded
    if isinstance(values[0], int | str):  # includes all flags
        return list(values)
    if isinstance(values[0], Point):
        return [None if place is None else pair(place) for place in values]
    return [_plain(value) for value in values]


def pair(place: Point) -> tuple[float, float]:
    """A place as a pair."""
    return round(place.x_m, DECIMALS), round(place.y_m, DECIMALS)


def _plain(value: object) -> Any:  # noqa: ANN401 - any value of a record, as JSON
    match value:
        case float():
            return round(value, DECIMALS)
        case Point():
            return pair(value)
        case Struct():
            return {name: _plain(part) for name, part in asdict(value).items()}
        case (float(), *_):
            return value  # ranges, which the world has already rounded
        case tuple() | list():
            return [_plain(part) for part in value]
        case _:
            return value
