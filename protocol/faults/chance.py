"""Random draws for fault plans: each draw is a hash of its subject, so no draw depends on another."""

from hashlib import blake2b
from struct import Struct

Draws = tuple[float, float, float, float]

_DIGEST = Struct(">4Q")
_SPARE_BITS = 11  # of 64: a double holds 53, and all 64 might be rounded to 1
_SPAN = 2.0**53


def draws(seed: int, *about: str | int) -> Draws:
    """Uniform numbers in [0, 1) for this seed and subject."""
    return Chance(seed, *about[:-1]).draws(about[-1])


class Chance:
    """The draws of one rule on one key at one receiver, message by message."""

    def __init__(self, seed: int, *about: str | int) -> None:
        text = "/".join(map(str, (seed, *about, "")))
        self._hash = blake2b(text.encode(), digest_size=_DIGEST.size)

    def draws(self, number: int | str) -> Draws:
        """The draws for the message with this number."""
        hashed = self._hash.copy()
        hashed.update(str(number).encode())
        one, two, three, four = _DIGEST.unpack(hashed.digest())
        return _even(one), _even(two), _even(three), _even(four)


def _even(number: int) -> float:
    return (number >> _SPARE_BITS) / _SPAN


def seed_of(draw: float) -> int:
    """A seed for further draws, made from one draw."""
    return int(draw * _SPAN)
