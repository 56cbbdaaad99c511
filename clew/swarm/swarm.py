"""The swarm: the world and the faults of a seed's episode. Pure.

Rule 1: some classes of faults are off in each seed, so that the others are tested without them.
Rule 2: half of the seeds are in safety mode: faults of any kind last to the end, and only the invariants are
        checked.
Rule 3: the others are in liveness mode. All faults end at `quiet_s`, except for dead robots, and for at most
        one robot with a permanent fault (`outside`) while the others are a majority of the living. Then the
        others must heal and arrive (`clew.campaign.liveness`).
Rule 4: in some seeds an adversary plays: one or two classes whose faults lie around one moment. There are
        fewer of the other classes then, so that their noise does not hide the adversary's effects.
"""

import math
from collections.abc import Iterable
from dataclasses import dataclass
from enum import StrEnum
from functools import lru_cache
from typing import Any

from clew.swarm.classes import ADVERSARY, INDEPENDENT, FaultClass, draw_rules
from clew.swarm.draws import Draws
from clew.swarm.window import SOON_S, Window
from clew.swarm.world import Ground, as_loaded, draw_world
from protocol.faults.plan import Plan
from protocol.faults.plan_text import plan_text
from protocol.faults.rules import Drop, Kill, Partition, Rule
from protocol.files.toml_text import toml_text
from protocol.keys import robot_name
from world.core import HEAL_S_MAX
from world.scenario.scenario import Scenario

SAFETY_S = 45.0  # three times what a fleet without faults takes: the faults have had their effect by then
QUIET_S = (8.0, 20.0)
ARRIVE_S = 120.0  # twice what the slowest fleet without faults takes, which lines up by turns
ON = 0.15  # share of seeds for each independent class: of 25 classes, three to four are on
ADVERSARY_SHARE = 0.4  # of seeds: each class of an adversary is in one seed of fifteen
ON_WITH_ADVERSARY = 0.4  # share of the independent classes that remain: one to two
OUTSIDE_SHARE = 0.15
HIDDEN_IN_QUEUE = 0.7  # a queue in which two robots see past the hidden body, two do not, and all can pass


class Mode(StrEnum):
    """What is checked in an episode."""

    SAFETY = "safety"
    LIVENESS = "liveness"


@dataclass(frozen=True, slots=True, kw_only=True)
class Swarm:
    """The world, plan and mode of a seed."""

    seed: int
    mode: Mode
    ground: Ground
    world: dict[str, Any]
    """The scenario, as in a scenario file."""
    plan: Plan
    classes: tuple[FaultClass, ...]
    quiet_s: float
    """When all faults are over, except for permanent ones; infinite in safety mode."""
    outside: frozenset[int] = frozenset()
    """The robots with a permanent fault in liveness mode."""

    @property
    def scenario(self) -> Scenario:
        """The loaded world."""
        return as_loaded(self.world)

    def world_text(self) -> str:
        """The world as a scenario file."""
        return toml_text(self.world)

    def plan_text(self) -> str:
        """The plan as a fault plan file."""
        return plan_text(self.plan)


@lru_cache(maxsize=1)  # a surprise is drawn again to write its files
def draw(seed: int) -> Swarm:
    """The swarm of a seed; the same on any machine."""
    draws = Draws(seed, "swarm/mix")
    mode = Mode.LIVENESS if draws.chance(0.5) else Mode.SAFETY
    quiet_s = draws.between(*QUIET_S)
    is_safety = mode is Mode.SAFETY
    time_s_max = SAFETY_S if is_safety else round(quiet_s + HEAL_S_MAX + ARRIVE_S, 3)
    classes = _draw_classes(seed, draws)
    hides = FaultClass.HIDDEN_BODY in classes and Draws(seed, "swarm/hides").chance(HIDDEN_IN_QUEUE)
    ground, world = draw_world(seed, time_s_max=time_s_max, queue=hides, must_arrive=not is_safety)
    robots = int(world["fleet"]["robots"])
    window = Window(robots, None if is_safety else quiet_s)
    rules = _draw_rules(seed, classes, window)
    outside: frozenset[int] = frozenset()
    if not is_safety:
        has_outside = robots >= 4 and draws.chance(OUTSIDE_SHARE)
        rules = without_excess_kills(rules, kills_max=robots - (3 if has_outside else 1))
        if has_outside:
            robot = draws.whole(1, robots)
            outside, rules = frozenset({robot}), [*rules, _permanent(robot, draws)]
    return Swarm(
        seed=seed,
        mode=mode,
        ground=ground,
        world=world,
        plan=Plan(name=f"swarm-{seed}", description=f"{mode} in {ground} ground", rules=tuple(rules)),
        classes=tuple(classes),
        quiet_s=math.inf if is_safety else quiet_s + SOON_S,
        outside=outside,
    )


def draw_faults(seed: int, robots: int) -> Plan:
    """Faults of any class, which may last to the end as in safety mode, for a world that no seed draws."""
    classes = _draw_classes(seed, Draws(seed, "swarm/faults"))
    return Plan(
        name=f"drawn-{seed}",
        description=f"drawn by seed {seed}: {', '.join(classes)}",
        rules=tuple(_draw_rules(seed, classes, Window(robots, None))),
    )


def _draw_classes(seed: int, draws: Draws) -> list[FaultClass]:
    return _with_adversary(
        seed, [each for each in INDEPENDENT if draws.chance(ON)] or [draws.pick(INDEPENDENT)]
    )


def _draw_rules(seed: int, classes: Iterable[FaultClass], window: Window) -> list[Rule]:
    return [rule for each in classes for rule in draw_rules(each, Draws(seed, f"swarm/{each}"), window)]


def _with_adversary(seed: int, independent: list[FaultClass]) -> list[FaultClass]:
    """The classes with those of an adversary (rule 4). Its own stream leaves all other seeds unchanged."""
    draws = Draws(seed, "swarm/adversary")
    if not draws.chance(ADVERSARY_SHARE):
        return independent
    some = draws.some(ADVERSARY, 2 if draws.chance(0.2) else 1)
    return [*(each for each in independent if draws.chance(ON_WITH_ADVERSARY)), *some]


def without_excess_kills(rules: list[Rule], *, kills_max: int) -> list[Rule]:
    """The rules without the kills that would leave too few robots."""
    kept: list[Rule] = []
    for rule in rules:
        if isinstance(rule, Kill):
            if rule.robots > kills_max:
                continue
            kills_max -= rule.robots
        kept.append(rule)
    return kept


def _permanent(robot: int, draws: Draws) -> Rule:
    """A permanent fault of one robot: its messages are lost, or those to it, or both."""
    name, from_s = robot_name(robot), draws.between(0.5, 8.0)
    match draws.whole(1, 4):
        case 1:
            return Drop(sender=(name,), probability=draws.between(0.8, 1.0), from_s=from_s)
        case 2:
            return Drop(receiver=(name,), probability=draws.between(0.8, 1.0), from_s=from_s)
        case 3:
            return Partition(group=(name,), others=("router",), from_s=from_s)
        case _:
            return Partition(group=(name,), from_s=from_s)
