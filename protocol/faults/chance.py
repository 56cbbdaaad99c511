"""Chance for fault plans: a draw is a hash of what it is about, so none depends on another or on an order."""

from hashlib import blake2b

DRAWS = 4  # of 8 bytes each out of one hash
SPAN = 2.0**64


def draws(seed: int, *about: str | int) -> tuple[float, ...]:
    """Numbers, even in [0, 1), that the seed draws about this."""
    text = "/".join(map(str, (seed, *about)))
    digest = blake2b(text.encode(), digest_size=8 * DRAWS).digest()
    return tuple(int.from_bytes(digest[i : i + 8]) / SPAN for i in range(0, 8 * DRAWS, 8))


class Chance:
    """The draws of one rule on one key at one receiver, message by message."""

    def __init__(self, seed: int, *about: str | int) -> None:
        self._hash = blake2b("/".join(map(str, (seed, *about, ""))).encode(), digest_size=8 * DRAWS)

    def draws(self, number: int) -> tuple[float, ...]:
        """Of the message with this number."""
        hashed = self._hash.copy()
        hashed.update(b"%d" % number)
        digest = hashed.digest()
        return tuple(int.from_bytes(digest[i : i + 8]) / SPAN for i in range(0, 8 * DRAWS, 8))
