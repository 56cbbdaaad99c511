"""The paper's Table I: distances from the leader's switching positions to each obstacle."""

from collections.abc import Sequence

import numpy as np

from protocol.frames import Point
from world.geometry.clearance import distances
from world.scenario.scenario import Scenario

Rows = tuple[tuple[float, ...], ...]


def measure(scenario: Scenario, positions: Sequence[Point]) -> Rows:
    """A row for each switching position, a column for each obstacle in the scenario's order [m].

    Args:
        scenario: the obstacles.
        positions: where the leader stood [world frame], as in `Tally.switching_positions`.
    """
    ground = scenario.ground
    return tuple(tuple(distances(ground, np.array([place.x_m, place.y_m])).tolist()) for place in positions)


def table_rms_m(scenario: Scenario, positions: Sequence[Point]) -> float | None:
    """The error against the scenario's table; only as many positions are measured as it has rows."""
    rows = len(scenario.table_m or ())
    return rms_m(measure(scenario, positions[:rows]), scenario.table_m)


def rms_m(measured: Rows, reference: Rows | None) -> float | None:
    """The root mean square of the differences to a reference table; None where rows are missing."""
    if reference is None or len(measured) < len(reference):
        return None
    differences_m = np.array(measured[: len(reference)]) - np.array(reference)
    return float(np.sqrt(np.mean(differences_m**2)))
