"""What damage does to the bytes of a message. Pure: what it draws is in the damage itself."""

from dataclasses import dataclass

from protocol.faults.chance import draws


@dataclass(frozen=True, slots=True)
class Damage:
    """Bits to flip in a payload, and whether it is cut off first; the seed says where."""

    bits: int
    truncate: bool
    seed: int

    def strike(self, payload: bytes) -> bytes:
        """The damaged payload: it is never the one that was sent, and may be empty."""
        if not payload:
            return payload
        struck = bytearray(payload)
        if self.truncate:
            del struck[int(draws(self.seed, "cut")[0] * len(struck)) :]
        for bit in self._places(8 * len(struck)):
            struck[bit // 8] ^= 1 << bit % 8
        return bytes(struck)

    def _places(self, room: int) -> set[int]:
        """Different bits, as many as there are to flip, or all."""
        places: set[int] = set()
        wanted, tried = min(self.bits, room), 0
        while len(places) < wanted:
            places.add(int(draws(self.seed, "flip", tried)[0] * room))
            tried += 1
        return places
