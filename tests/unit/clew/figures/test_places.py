"""Figures for print: lines and obstacles are drawn at the right places."""

import numpy as np
import pytest

from protocol.arrays import Floats
from tests.support.figures import chart, course, painted
from tests.support.runs import Runs


def test_limit_lines_are_at_the_required_clearance(runs: Runs) -> None:
    drawn = course(runs.of("grove"))
    law = drawn.scenario.law
    [axes] = painted(chart(drawn, "distances"))
    heights_m = {str(line.get_label()): set(np.asarray(line.get_ydata()).tolist()) for line in axes.lines}
    assert heights_m[r"$\varepsilon$"] == {law.epsilon_m}
    assert heights_m[r"$\varepsilon - \mu_0$"] == {law.epsilon_m - law.mu0_m}


def test_each_panel_shows_moving_obstacles_at_the_time_of_its_plan(runs: Runs) -> None:
    drawn = course(runs.of("pedestrian", faults="leader-killed"))
    panels = [axes for axes in painted(chart(drawn, "steps")) if axes.get_title()]
    places_m, drawn_m = list[Floats](), list[Floats]()
    for axes, planned in zip(panels, drawn.steps, strict=True):
        [moving] = [patch for patch in axes.patches if patch.get_hatch()]
        box = moving.get_path().get_extents(moving.get_patch_transform())
        drawn_m.append(np.mean(box.get_points(), axis=0))
        places_m.extend(drawn.scenario.movers.places_m(planned.t_s))
    assert np.diff(drawn_m, axis=0) == pytest.approx(np.diff(places_m, axis=0), abs=1e-6)
    assert np.ptp(places_m, axis=0).max() > 0.1
