"""A verdict agrees with true poses, or the second judge says in what it does not."""

from typing import Any

import pytest

from clew.judge.agree import differences, disagreements
from clew.judge.poses import Least
from tests.support.judges import found, poses, scenario

POST = {"shape": "circle", "centre_m": [4.0, 0.4], "radius_m": 0.2}
ARRIVED = [*poses(1, (0.0, 4.0, 0.0)), *poses(2, (0.0, 3.73, 0.0))]
SHORT = [*poses(1, (0.0, 3.6, 0.0)), *poses(2, (0.0, 3.33, 0.0))]
SAID: dict[str, Any] = {
    "ok": True,
    "clearance_m_min": 0.1,
    "moving_clearance_m_min": None,
    "separation_m_min": 0.07,
    "violations_by_invariant": {"S1": 0, "S2": 0, "S3": 0, "F1": 0},
    "goal_reached": True,
    "robots_arrived": 2,
}


def differs(said: dict[str, Any], entries: list[dict[str, Any]] = ARRIVED, **changes: object) -> list[str]:
    return list(disagreements(found(entries, scenario(obstacle=[POST], **changes)), SAID | said))


def test_the_same_distances_and_the_same_arrival_agree() -> None:
    assert differs({}) == []


@pytest.mark.parametrize(
    ("field", "value"),
    [
        ("clearance_m_min", 0.1001),
        ("clearance_m_min", None),
        ("separation_m_min", 0.0699),
        ("moving_clearance_m_min", 1.0),
        ("robots_arrived", 3),
        ("violations_by_invariant", {"S1": 1}),
        ("violations_by_invariant", {"S2": 1}),
    ],
)
def test_another_figure_is_named(field: str, value: object) -> None:
    [said] = differs({field: value})
    assert said.startswith(field if field != "violations_by_invariant" else next(iter(SAID[field])) and "S")


def test_a_breach_that_the_verdict_does_not_count_is_named() -> None:
    law = {"law": "certified", "epsilon_m": 0.13, "mu0_m": 0.02}
    assert differs({}, law=law)[0].startswith(
        "S1 (clearance) counts as kept, by true poses robot 1 and obstacle 1"
    )
    assert differs({"violations_by_invariant": {"S1": 3}}, law=law) == []


def test_an_arrival_that_poses_do_not_show_is_named() -> None:
    said = differs({"clearance_m_min": found(SHORT, scenario(obstacle=[POST])).clearance.distance_m}, SHORT)  # type: ignore[union-attr] # there is a post
    assert [each.partition(",")[0] for each in said] == ["ok", "goal_reached", "robots_arrived is 2"]


def test_a_goal_that_was_left_again_was_reached() -> None:
    left = [*poses(1, (0.0, 4.0, 0.0), (9.0, 3.6, 0.0)), *poses(2, (0.0, 3.73, 0.0), (9.0, 3.33, 0.0))]
    assert differs({"ok": False, "robots_arrived": 0}, left) == []


@pytest.mark.parametrize(("second_m", "agrees"), [(0.18, True), (0.6, False)])
def test_a_robot_at_the_goal_beside_the_chain_may_have_arrived(second_m: float, agrees: bool) -> None:
    """The first one had arrived and died, and the run was over before anybody missed it."""
    beside = [*poses(1, (0.0, 4.0, -0.25)), *poses(2, (0.0, 4.0, second_m))]
    finding = found(beside, scenario(goal={"at_m": [4.0, 0.0], "tolerance_m": 0.3}))
    assert finding.chain == (1,)
    said = SAID | {"ok": False, "clearance_m_min": None, "separation_m_min": finding.separation.distance_m}  # type: ignore[union-attr] # there are two hulls
    assert (list(disagreements(finding, said)) == []) is agrees


@pytest.mark.parametrize("ok", [True, False])
def test_a_failed_verdict_that_measured_nothing_is_not_compared(ok: bool) -> None:
    nothing = dict.fromkeys(("clearance_m_min", "separation_m_min"))
    assert bool(differs({**nothing, "ok": ok})) is ok


@pytest.mark.parametrize("measured", [True, False])
def test_a_failed_verdict_on_several_fleets_that_measured_nothing_is_not_compared(measured: bool) -> None:
    """The launcher writes it when their world was killed: it knows where they started."""
    near = [Least(distance_m=0.14, t_s=7.3, what="robot 1 of east and robot 1 of west")]
    said = {"ok": False, "sim_s": 7.4 * measured, "between_m_min": 5.8, "contact_count": 0, "fleets": {}}
    assert bool(list(differences(near, {}, said))) is measured


def test_a_verdict_may_fail_for_what_poses_do_not_show() -> None:
    assert differs({"ok": False, "violations_by_invariant": {"S1": 0, "F1": 2}, "robots_arrived": 1}) == []
