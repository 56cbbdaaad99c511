"""Three robots of a strand over a network that loses, delays, duplicates and reorders: none collide."""

import math
from collections import Counter
from itertools import combinations, pairwise

import numpy as np
from hypothesis import given
from hypothesis import strategies as st

from agents.commands import Tell
from agents.events import LinkHeard
from agents.navigation.certificate import certified_lengths_m
from agents.strand.strand import Strand
from protocol.frames import Point, Pose
from tests.support.stages.one_step import under
from tests.support.stages.strand_stage import formation, own, queue_path

MISSION = under("certified", robots=3, robot_radius_m=0.1, separation_m=0.1)
KEEP_M = 0.31  # two radii, the separation and the tolerance
ORDER = (3, 2, 1)
LEADER, TAIL = ORDER[0], ORDER[-1]
ROUNDING_M = 1e-8  # of some 50 arc lengths, each with the touching tolerance

robots = st.sampled_from(ORDER)
shares = st.one_of(st.just(1.0), st.floats(0.0, 1.0))
actions = st.lists(
    st.one_of(
        st.tuples(st.just("tell"), robots, st.just(0.0)),
        st.tuples(st.just("deliver"), st.integers(0, 50), shares),
        st.tuples(st.just("drive"), robots, shares),
        st.tuples(st.just("step"), st.floats(0.1, 2.0), st.floats(-math.pi, math.pi)),
    ),
    max_size=60,
)
# The nearest queue that a scenario allows, one with a grant's length more, and one far apart.
spacings_m = st.sampled_from([0.3, 0.33, 0.4, 1.0])


class Stage:
    """The robots' strands and places on the path, and the messages in transit."""

    def __init__(self, spacing_m: float) -> None:
        places = {robot: Pose(x_m=spacing_m * robot, y_m=0.0, heading_rad=0.0) for robot in ORDER}
        places_m = {robot: spacing_m * (robot - 1) for robot in ORDER}
        self.strands = {}
        for robot in ORDER:
            path = queue_path(ORDER, places)
            told = formation(robot, ORDER, places, places_m, path)
            self.strands[robot] = Strand(robot, told, path, MISSION, 0.0)
        self.progress_m = {robot: self.strands[robot].start_m for robot in ORDER}
        self.on_their_way: list[tuple[int, LinkHeard]] = []
        self._numbers: Counter[tuple[int, int]] = Counter()
        self._now_s = 0.0

    def tell(self, robot: int) -> None:
        self._now_s += MISSION.heartbeat_s
        for command in self.strands[robot].tell(own(self.progress_m[robot]), self._now_s):
            if isinstance(command, Tell):
                self._numbers[robot, command.robot] += 1
                heard = LinkHeard(robot, self._numbers[robot, command.robot], command.state)
                self.on_their_way.append((command.robot, heard))

    def deliver(self, index: int, *, keep: bool) -> None:
        """Deliver a message in transit; `keep` leaves it in transit, so that it arrives again."""
        if self.on_their_way:
            at = index % len(self.on_their_way)
            receiver, heard = self.on_their_way[at] if keep else self.on_their_way.pop(at)
            assert self.strands[receiver].hear(heard, self._now_s) == [], "nothing true is refused"

    def drive(self, robot: int, share: float) -> None:
        strand = self.strands[robot]
        to_m = strand.path.end_m if robot == LEADER else min(strand.authority_m, strand.path.end_m)
        self.progress_m[robot] += share * max(0.0, to_m - self.progress_m[robot])

    def step(self, length_m: float, heading_rad: float) -> None:
        """The leader plans a step that keeps its distance from all ground that it has granted."""
        strand = self.strands[LEADER]
        if self.progress_m[LEADER] < strand.path.end_m:
            return
        here = strand.path.at(strand.path.end_m)
        origin, walls = np.array([here.x_m, here.y_m]), strand.grants.ground.walls
        free_m = float(certified_lengths_m(origin, np.array([heading_rad]), walls)[0])
        heading = np.array([math.cos(heading_rad), math.sin(heading_rad)])
        x_m, y_m = origin + min(free_m, length_m) * heading
        strand.path.extend(Point(x_m=x_m, y_m=y_m))

    def act(self, what: str, which: float, how: float) -> None:
        match what:
            case "tell":
                self.tell(int(which))
            case "deliver":
                self.deliver(int(which), keep=how < 0.5)
            case "drive":
                self.drive(int(which), how)
            case _:
                self.step(which, how)

    def least_apart_m(self) -> float:
        path = self.strands[LEADER].path
        places = [path.at(self.progress_m[robot]) for robot in ORDER]
        return min(math.hypot(a.x_m - b.x_m, a.y_m - b.y_m) for a, b in combinations(places, 2))


@given(spacings_m, actions)
def test_no_message_fault_brings_two_robots_too_near(
    spacing_m: float, actions: list[tuple[str, float, float]]
) -> None:
    stage = Stage(spacing_m)
    for action in actions:
        stage.act(*action)
        assert stage.least_apart_m() >= min(KEEP_M, spacing_m) - ROUNDING_M


@given(spacings_m, actions)
def test_no_robot_knows_more_than_was_sent(spacing_m: float, actions: list[tuple[str, float, float]]) -> None:
    stage = Stage(spacing_m)
    for action in actions:
        stage.act(*action)
        whole = stage.strands[LEADER].path
        for ahead, behind in pairwise(ORDER):
            granter, follower = stage.strands[ahead], stage.strands[behind]
            assert follower.authority_m <= granter.grants.granted_m
            assert follower.path.told_from(0, 99) == whole.told_from(0, len(follower.path))
            assert granter.grants.tail_m <= stage.progress_m[TAIL]


@given(spacings_m, actions)
def test_when_messages_arrive_again_all_know_the_path_and_their_authority(
    spacing_m: float, actions: list[tuple[str, float, float]]
) -> None:
    stage = Stage(spacing_m)
    for action in actions:
        stage.act(*action)
    stage.on_their_way.clear()
    for _ in range(2 * len(ORDER)):  # there and back along all links
        for robot in ORDER:
            stage.tell(robot)
        while stage.on_their_way:
            stage.deliver(0, keep=False)
    whole = stage.strands[LEADER].path
    for ahead, behind in pairwise(ORDER):
        assert stage.strands[behind].path.told_from(0, 99) == whole.told_from(0, 99)
        assert stage.strands[behind].authority_m == stage.strands[ahead].grants.granted_m
        assert stage.strands[ahead].grants.tail_m == stage.progress_m[TAIL]
