"""The swarm: what goes wrong in the episode of a seed, and in what world. Pure.

Rule 1: some classes of faults are off altogether, so that the others are seen without them.
Rule 2: one seed in two is in safety mode: anything goes, to the end, and invariants alone are asked for.
Rule 3: the others are in liveness mode. All faults are over at `quiet_s`, but for the dead, and for one robot
        at most that goes on suffering (`outside`) while those without it are more than half of the living.
        Then they must heal and arrive (`clew.campaign.liveness`).
Rule 4: in some seeds an adversary plays: one or two classes whose faults lie around one moment, and of the
        others fewer, so that their noise does not hide what these do.
"""

import math
from dataclasses import dataclass
from enum import StrEnum
from typing import Any

from clew.swarm.classes import ADVERSARY, WEATHER, FaultClass, draw_rules
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

SAFETY_S = 45.0  # three times what a fleet takes that suffers nothing: what is to go wrong has, by then
QUIET_S = (8.0, 20.0)
ARRIVE_S = 120.0  # twice what the slowest fleet takes that suffers nothing, and lines up by turns
ON = 0.16  # of each class of weather: of 23, three to four are on
ADVERSE = 0.4  # of seeds: so each class of an adversary is in one seed of twelve
ADVERSE_ON = 0.4  # of the weather that there would have been: one to two classes of it
OUTSIDE = 0.15
HIDES_IN_QUEUE = 0.7  # where one can be between two that see and two that do not, and all can pass


class Mode(StrEnum):
    """What is asked of an episode."""

    SAFETY = "safety"
    LIVENESS = "liveness"


@dataclass(frozen=True, slots=True, kw_only=True)
class Swarm:
    """What a seed has drawn."""

    seed: int
    mode: Mode
    ground: Ground
    world: dict[str, Any]
    """The scenario, as a file would say it."""
    plan: Plan
    classes: tuple[FaultClass, ...]
    quiet_s: float
    """When all faults are over, but for permanent ones; in safety mode that is never."""
    outside: frozenset[int] = frozenset()
    """Who goes on suffering in liveness mode."""

    @property
    def scenario(self) -> Scenario:
        """The world, loaded."""
        return as_loaded(self.world)

    def world_text(self) -> str:
        """The world as a scenario file."""
        return toml_text(self.world)

    def plan_text(self) -> str:
        """The plan as a file."""
        return plan_text(self.plan)


def draw(seed: int) -> Swarm:
    """What the seed draws; the same on any machine."""
    draws = Draws(seed, "swarm/mix")
    mode = Mode.LIVENESS if draws.chance(0.5) else Mode.SAFETY
    quiet_s = draws.between(*QUIET_S)
    is_safety = mode is Mode.SAFETY
    time_s_max = SAFETY_S if is_safety else round(quiet_s + HEAL_S_MAX + ARRIVE_S, 3)
    classes = _adverse(seed, [each for each in WEATHER if draws.chance(ON)] or [draws.pick(WEATHER)])
    hides = FaultClass.HIDDEN_BODY in classes and Draws(seed, "swarm/hides").chance(HIDES_IN_QUEUE)
    ground, world = draw_world(seed, time_s_max=time_s_max, queue=hides)
    robots = int(world["fleet"]["robots"])
    window = Window(robots, None if is_safety else quiet_s)
    rules = [rule for each in classes for rule in draw_rules(each, Draws(seed, f"swarm/{each}"), window)]
    outside: frozenset[int] = frozenset()
    if not is_safety:
        has_outside = robots >= 4 and draws.chance(OUTSIDE)
        rules = _spared(rules, kills_max=robots - (3 if has_outside else 1))
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


def _adverse(seed: int, weather: list[FaultClass]) -> list[FaultClass]:
    """Rule 4; from a stream of its own, so that the weather of all other seeds is what it was without."""
    draws = Draws(seed, "swarm/adversary")
    if not draws.chance(ADVERSE):
        return weather
    some = draws.some(ADVERSARY, 2 if draws.chance(0.2) else 1)
    return [*(each for each in weather if draws.chance(ADVERSE_ON)), *some]


def _spared(rules: list[Rule], *, kills_max: int) -> list[Rule]:
    """The rules, without kills that would leave too few."""
    spared: list[Rule] = []
    for rule in rules:
        if isinstance(rule, Kill):
            if rule.robots > kills_max:
                continue
            kills_max -= rule.robots
        spared.append(rule)
    return spared


def _permanent(robot: int, draws: Draws) -> Rule:
    """A fault that one robot suffers to the end: the others do not hear it, or it hears nobody, or both."""
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
