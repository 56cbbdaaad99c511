"""Robots of a strand over a network that loses, delays, duplicates and reorders: none collide."""

import math
from collections import Counter
from collections.abc import Mapping
from itertools import combinations, pairwise

import numpy as np
from hypothesis import given, settings
from hypothesis import strategies as st

from agents.commands import Tell
from agents.events import LinkHeard
from agents.navigation.certificate import certified_lengths_m
from agents.strand.strand import Strand
from protocol.frames import Point, Pose
from protocol.path import Path
from tests.support.stages.one_step import under
from tests.support.stages.strand_stage import formation, own, queue_path
from tests.support.strategies.examples import examples

MISSION = under("certified", robots=3, robot_radius_m=0.1, separation_m=0.1)
KEEP_M = 0.31  # two radii, the separation and the tolerance
ORDER = (3, 2, 1)
ROUNDING_M = 1e-8  # of some 50 arc lengths, each with the touching tolerance

APART_M = 0.3  # the same without the tolerance: what bodies keep that stand beside their path
ranks = st.integers(0, 3)
shares = st.one_of(st.just(1.0), st.floats(0.0, 1.0))
actions = st.lists(
    st.one_of(
        st.tuples(st.just("tell"), ranks, st.just(0.0)),
        st.tuples(st.just("deliver"), st.integers(0, 50), shares),
        st.tuples(st.just("drive"), ranks, shares),
        st.tuples(st.just("step"), st.floats(0.1, 2.0), st.floats(-math.pi, math.pi)),
    ),
    max_size=60,
)
Move = tuple[int, int]
walks = st.lists(st.sampled_from([(1, 0), (0, 1), (-1, 0), (0, -1)]), max_size=16)
pitches_m = st.sampled_from([0.3, 0.302, 0.31, 0.4])
# The nearest queue that a scenario allows, one with a grant's length more, and one far apart.
spacings_m = st.sampled_from([0.3, 0.33, 0.4, 1.0])


class Stage:
    """The robots' strands and places on the path, and the messages in transit."""

    def __init__(self, path: Path, places_m: Mapping[int, float]) -> None:
        """Put robots on a path; `places_m` are their arc lengths, leader first."""
        self.order = tuple(places_m)
        self.leader, self.tail = self.order[0], self.order[-1]
        at = {robot: path.at(s_m) for robot, s_m in places_m.items()}
        places = {robot: Pose(x_m=each.x_m, y_m=each.y_m, heading_rad=0.0) for robot, each in at.items()}
        self.strands = {}
        for robot in self.order:
            told = formation(robot, self.order, places, places_m, path)
            self.strands[robot] = Strand(robot, told, path.copy(), MISSION, 0.0)
        self.progress_m = dict(places_m)
        self.on_their_way: list[tuple[int, LinkHeard]] = []
        self._numbers: Counter[tuple[int, int]] = Counter()
        self._now_s = 0.0

    @classmethod
    def queue(cls, spacing_m: float) -> "Stage":
        """Robots in a straight queue."""
        places = {robot: Pose(x_m=spacing_m * robot, y_m=0.0, heading_rad=0.0) for robot in ORDER}
        return cls(queue_path(ORDER, places), {robot: spacing_m * (robot - 1) for robot in ORDER})

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
        strand, progress_m = self.strands[robot], self.progress_m[robot]
        to_m = min(strand.authority_m, strand.path.end_m) if robot != self.leader else strand.path.end_m
        to_m = strand.grants.claim_m(to_m, progress_m=progress_m)
        self.progress_m[robot] += share * max(0.0, to_m - progress_m)

    def step(self, length_m: float, heading_rad: float) -> None:
        """The leader plans a step that keeps its distance from all ground that it has granted."""
        strand = self.strands[self.leader]
        if self.progress_m[self.leader] < strand.path.end_m:
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
                self.tell(self.order[int(which) % len(self.order)])
            case "deliver":
                self.deliver(int(which), keep=how < 0.5)
            case "drive":
                self.drive(self.order[int(which) % len(self.order)], how)
            case _:
                self.step(which, how)

    def least_apart_m(self) -> float:
        path = self.strands[self.leader].path
        places = [path.at(self.progress_m[robot]) for robot in self.order]
        return min(math.hypot(a.x_m - b.x_m, a.y_m - b.y_m) for a, b in combinations(places, 2))


def beside_itself(walk: list[Move]) -> list[tuple[int, int]]:
    """The places of a walk on a grid, without the steps that would come to a place again."""
    nodes = [(0, 0), (1, 0)]
    for along, across in walk:
        node = (nodes[-1][0] + along, nodes[-1][1] + across)
        nodes += [node] if node not in nodes else []
    return nodes


@given(spacings_m, actions)
def test_no_message_fault_brings_two_robots_too_near(
    spacing_m: float, actions: list[tuple[str, float, float]]
) -> None:
    stage = Stage.queue(spacing_m)
    for action in actions:
        stage.act(*action)
        assert stage.least_apart_m() >= min(KEEP_M, spacing_m) - ROUNDING_M


@settings(max_examples=examples(300))
@given(walks, walks, pitches_m, st.tuples(st.integers(0, 23), st.integers(0, 23)), actions)
def test_robots_of_a_strand_that_bends_back_keep_their_distance_on_a_path_that_leads_over_their_own_ground(
    behind: list[Move],
    onward: list[Move],
    pitch_m: float,
    between: tuple[int, int],
    actions: list[tuple[str, float, float]],
) -> None:
    """Where legs were driven, robots may be so near (`agents.coordinating.folding`, rule 2).

    Where a strand has turned round, the path leads on over ground on which no robot was at the end.
    """
    nodes = beside_itself(behind)
    last = len(nodes) - 1
    ranks = [0, *sorted({last, *(1 + node % last for node in between)})]
    for along, across in onward:
        nodes.append((nodes[-1][0] + along, nodes[-1][1] + across))
    path = Path(Point(x_m=pitch_m * x, y_m=pitch_m * y) for x, y in nodes)
    stage = Stage(path, {1 + rank: path[node].s_m for rank, node in reversed(list(enumerate(ranks)))})
    for action in actions:
        stage.act(*action)
        assert stage.least_apart_m() >= APART_M - ROUNDING_M


@given(spacings_m, actions)
def test_no_robot_knows_more_than_was_sent(spacing_m: float, actions: list[tuple[str, float, float]]) -> None:
    stage = Stage.queue(spacing_m)
    for action in actions:
        stage.act(*action)
        whole = stage.strands[stage.leader].path
        for ahead, behind in pairwise(ORDER):
            granter, follower = stage.strands[ahead], stage.strands[behind]
            assert follower.authority_m <= granter.grants.granted_m
            assert follower.path.told_from(0, 99) == whole.told_from(0, len(follower.path))
            assert granter.grants.tail_m <= stage.progress_m[stage.tail]


@given(spacings_m, actions)
def test_when_messages_arrive_again_all_know_the_path_and_their_authority(
    spacing_m: float, actions: list[tuple[str, float, float]]
) -> None:
    stage = Stage.queue(spacing_m)
    for action in actions:
        stage.act(*action)
    stage.on_their_way.clear()
    for _ in range(2 * len(ORDER)):  # there and back along all links
        for robot in ORDER:
            stage.tell(robot)
        while stage.on_their_way:
            stage.deliver(0, keep=False)
    whole = stage.strands[stage.leader].path
    for ahead, behind in pairwise(ORDER):
        assert stage.strands[behind].path.told_from(0, 99) == whole.told_from(0, 99)
        assert stage.strands[behind].authority_m == stage.strands[ahead].grants.granted_m
        assert stage.strands[ahead].grants.tail_m == stage.progress_m[stage.tail]
