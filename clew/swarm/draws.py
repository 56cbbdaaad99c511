"""Random draws for worlds and fault plans. Numbers are rounded, so that people can read them."""

import math
from collections.abc import Sequence
from typing import TypeVar

from world.chance import stream

T = TypeVar("T")

DECIMALS = 3


class Draws:
    """The stream of draws for one purpose of a seed. An additional draw does not change other streams."""

    def __init__(self, seed: int, purpose: str) -> None:
        self._stream = stream(seed, purpose)

    def chance(self, probability: float) -> bool:
        """True with this probability."""
        return bool(self._stream.random() < probability)

    def between(self, low: float, high: float) -> float:
        """A number, uniformly distributed."""
        return round(float(self._stream.uniform(low, high)), DECIMALS)

    def scale(self, low: float, high: float) -> float:
        """A number, log-uniformly distributed: each order of magnitude is equally likely."""
        return round(math.exp(self._stream.uniform(math.log(low), math.log(high))), DECIMALS)

    def whole(self, low: int, high: int) -> int:
        """An integer; both ends are included."""
        return int(self._stream.integers(low, high, endpoint=True))

    def pick(self, choices: Sequence[T]) -> T:
        """One of the choices."""
        return choices[int(self._stream.integers(len(choices)))]

    def some(self, choices: Sequence[T], count: int) -> list[T]:
        """A sample of `count` different choices, in their original order."""
        places = self._stream.choice(len(choices), size=count, replace=False)
        return [choices[int(place)] for place in sorted(places)]
