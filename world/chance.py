"""Seeded random streams, one per purpose, so that an additional draw in one does not change the others."""

from hashlib import blake2b

import numpy as np


def stream(seed: int, purpose: str) -> np.random.Generator:
    """The stream of random numbers for one purpose of a run."""
    digest = blake2b(f"{seed}/{purpose}".encode(), digest_size=8).digest()
    return np.random.Generator(np.random.PCG64(int.from_bytes(digest, "big")))
