import tomllib
from pathlib import Path

import pytest

from clew.campaign.liveness import at_end, liveness_failure
from clew.rehearsal.rehearsal import Rehearsal
from clew.swarm.classes import ADVERSARY, FaultClass
from clew.swarm.swarm import Mode, Swarm, draw
from clew.swarm.window import SOON_S
from clew.swarm.world import OTHER_SEPARATIONS_M, Ground
from protocol.faults.fit import check_fits
from protocol.faults.plan import Plan
from protocol.faults.rules import Freeze, Kill, Partition, Restart, Slow
from protocol.files.reading import understand
from protocol.keys import robot_name
from world.scenario.scenario import Scenario
from world.scenario.scenario import load as load_scenario

SEEDS = range(1, 51)


@pytest.fixture(scope="module")
def drawn() -> dict[int, Swarm]:
    return {seed: draw(seed) for seed in SEEDS}


@pytest.fixture(scope="module")
def lively(drawn: dict[int, Swarm]) -> list[Swarm]:
    return [swarm for swarm in drawn.values() if swarm.mode is Mode.LIVENESS]


def test_a_seed_always_draws_the_same(drawn: dict[int, Swarm]) -> None:
    assert all(draw(seed) == drawn[seed] for seed in (1, 2, 3))


def test_every_class_ground_and_mode_is_drawn_and_each_class_is_off_in_some_seed(
    drawn: dict[int, Swarm],
) -> None:
    mixes = [set(swarm.classes) for swarm in drawn.values()]
    assert set[FaultClass]().union(*mixes) == set(FaultClass)
    assert set[FaultClass]().union(*(set(FaultClass) - mix for mix in mixes)) == set(FaultClass)
    assert {swarm.ground for swarm in drawn.values()} == set(Ground)
    assert {swarm.mode for swarm in drawn.values()} == set(Mode)


def test_some_worlds_have_another_separation_and_some_where_nobody_has_to_arrive_a_walker_or_no_goal(
    drawn: dict[int, Swarm],
) -> None:
    """Somebody who stays in the way for good would excuse every fleet that does not arrive."""
    separations_m = [swarm.scenario.fleet.separation_m for swarm in drawn.values()]
    assert set(separations_m) == {0.05, *OTHER_SEPARATIONS_M}
    assert separations_m.count(0.05) > len(separations_m) / 2
    walked = [swarm for swarm in drawn.values() if swarm.scenario.moving]
    assert 2 <= len(walked) < len(drawn) / 4
    astray = [swarm for swarm in drawn.values() if swarm.scenario.goal is None]
    assert 2 <= len(astray) < len(drawn) / 4
    assert {swarm.mode for swarm in (*walked, *astray)} == {Mode.SAFETY}


def test_every_drawn_plan_fits_its_fleet(drawn: dict[int, Swarm]) -> None:
    for swarm in drawn.values():
        check_fits(swarm.plan, robots=swarm.scenario.fleet.robots)


def test_an_adversary_adds_at_most_two_classes_and_reduces_the_independent_ones(
    drawn: dict[int, Swarm],
) -> None:
    mixes = [set(swarm.classes) for swarm in drawn.values()]
    adverse = [mix for mix in mixes if mix & set(ADVERSARY)]
    assert all(len(mix & set(ADVERSARY)) <= 2 for mix in adverse)
    assert 0.25 < len(adverse) / len(mixes) < 0.55
    quiet = [mix for mix in mixes if not mix & set(ADVERSARY)]
    assert sum(map(len, adverse)) / len(adverse) < sum(map(len, quiet)) / len(quiet)


@pytest.mark.parametrize("seed", [1, 2, 28, 97])
def test_drawn_world_and_plan_can_be_read_back_from_their_files(seed: int, tmp_path: Path) -> None:
    swarm = draw(seed)
    assert understand(tomllib.loads(swarm.plan_text()), Plan, "plan") == swarm.plan
    (tmp_path / "world.toml").write_text(swarm.world_text(), encoding="utf-8")
    assert load_scenario(str(tmp_path / "world.toml")).fingerprint() == swarm.scenario.fingerprint()
    assert isinstance(swarm.scenario, Scenario)


def test_no_robot_is_cut_off_from_the_router_before_it_has_started(drawn: dict[int, Swarm]) -> None:
    rules = [rule for swarm in drawn.values() for rule in swarm.plan.rules if isinstance(rule, Partition)]
    begin_s = [rule.from_s for rule in rules if "router" in rule.others]
    assert len(begin_s) > 5
    assert min(begin_s) >= SOON_S


def test_in_liveness_mode_all_faults_but_deaths_and_permanent_ones_end_in_time(
    lively: list[Swarm],
) -> None:
    for swarm in lively:
        names = {robot_name(robot) for robot in swarm.outside}
        for rule in swarm.plan.rules:
            ends_s = [rule.until_s]
            if isinstance(rule, Freeze | Slow) and rule.until_s is not None and rule.for_s is not None:
                ends_s = [rule.from_s + rule.for_s]
            if isinstance(rule, Restart):
                ends_s = [rule.from_s + rule.after_s]
            group = set(rule.group) if isinstance(rule, Partition) else {*getattr(rule, "sender", ())}
            lasts = bool(names) and group | {*getattr(rule, "receiver", ())} == names
            ends = all(end_s is not None and end_s <= swarm.quiet_s for end_s in ends_s)
            assert lasts or ends, (swarm.seed, rule)


def test_in_liveness_mode_the_healthy_core_is_a_majority_of_the_living(lively: list[Swarm]) -> None:
    for swarm in lively:
        killed = sum(rule.robots for rule in swarm.plan.rules if isinstance(rule, Kill))
        living, outside = swarm.scenario.fleet.robots - killed, len(swarm.outside)
        assert living >= 1, swarm.seed
        assert outside == 0 or 2 * (living - outside) > living, swarm.seed


def test_a_fleet_that_could_heal_and_does_not_is_detected(lively: list[Swarm]) -> None:
    swarm = next(swarm for swarm in lively if swarm.ground is Ground.OPEN)
    cut = Partition(group=("r1",), from_s=0.5)
    rehearsal = Rehearsal(swarm.scenario, swarm.seed, Plan(name="cut", rules=(cut,))).run()
    judged = liveness_failure(at_end(rehearsal.world), rehearsal.entries, quiet_s=1.0, outside=frozenset())
    assert judged is not None
    alone = liveness_failure(
        at_end(rehearsal.world), rehearsal.entries, quiet_s=1.0, outside=frozenset({1, 2, 3, 4, 5})
    )
    assert alone is None, "robots outside the core are not checked"
