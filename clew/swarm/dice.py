"""Draws for whoever makes up worlds and fault plans. Numbers are rounded, so that people can read them."""

import math
from collections.abc import Sequence
from typing import TypeVar

from world.chance import stream

T = TypeVar("T")

DECIMALS = 3


class Dice:
    """One stream of draws for one purpose of a seed: a draw more in one does not move the others."""

    def __init__(self, seed: int, purpose: str) -> None:
        self._stream = stream(seed, purpose)

    def chance(self, probability: float) -> bool:
        """Whether something comes true."""
        return bool(self._stream.random() < probability)

    def between(self, low: float, high: float) -> float:
        """A number, all between alike."""
        return round(float(self._stream.uniform(low, high)), DECIMALS)

    def scale(self, low: float, high: float) -> float:
        """A number whose order of magnitude is drawn: small ones as often as large ones."""
        return round(math.exp(self._stream.uniform(math.log(low), math.log(high))), DECIMALS)

    def whole(self, low: int, high: int) -> int:
        """A whole number, both ends included."""
        return int(self._stream.integers(low, high, endpoint=True))

    def pick(self, choices: Sequence[T]) -> T:
        """One of them."""
        return choices[int(self._stream.integers(len(choices)))]

    def some(self, choices: Sequence[T], count: int) -> list[T]:
        """So many of them, each once, in their order."""
        places = self._stream.choice(len(choices), size=count, replace=False)
        return [choices[int(place)] for place in sorted(places)]
