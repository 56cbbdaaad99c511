"""Damage to the bytes of a message. Pure: the damage carries its own seed."""

from dataclasses import dataclass

from protocol.faults.chance import draws


@dataclass(frozen=True, slots=True)
class Damage:
    """Bits to flip in a payload, and whether it is truncated first; the seed decides where."""

    bits: int
    truncate: bool
    seed: int

    def apply(self, payload: bytes) -> bytes:
        """The damaged payload. It always differs from the payload that was sent, and it may be empty."""
        if not payload:
            return payload
        damaged = bytearray(payload)
        if self.truncate:
            del damaged[int(draws(self.seed, "cut")[0] * len(damaged)) :]
        for bit in self._places(8 * len(damaged)):
            damaged[bit // 8] ^= 1 << bit % 8
        return bytes(damaged)

    def _places(self, room: int) -> set[int]:
        """The positions of `bits` different bits, or of all bits where the payload has fewer."""
        places: set[int] = set()
        wanted, tried = min(self.bits, room), 0
        while len(places) < wanted:
            places.add(int(draws(self.seed, "flip", tried)[0] * room))
            tried += 1
        return places
