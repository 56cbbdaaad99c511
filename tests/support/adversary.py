"""An adversary that chooses errors of drives."""

from collections.abc import Callable
from unittest.mock import Mock

import numpy as np

from world.chance import stream


def adverse(off: Callable[[float, float], float]) -> Callable[[int, str], np.random.Generator]:
    """As drawn, but for an adversary's drives: each is off by what it chooses between two limits."""

    def drawn_or_chosen(seed: int, purpose: str) -> np.random.Generator:
        drawn = stream(seed, purpose)
        if not purpose.startswith("drive/"):
            return drawn
        adversary = Mock(spec=drawn)
        adversary.uniform.side_effect = off
        return adversary

    return drawn_or_chosen
