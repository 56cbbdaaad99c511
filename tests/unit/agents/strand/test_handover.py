"""The leader's hand-over through a strand, over a network that loses, delays, duplicates and reorders."""

from collections import Counter
from itertools import pairwise

import numpy as np
from hypothesis import given, settings
from hypothesis import strategies as st
from msgspec.structs import replace

from agents.body.driver import Driver
from agents.body.senses import Senses
from agents.commands import Tell
from agents.events import LinkHeard
from agents.strand.member import Member
from agents.strand.memory import Memory
from protocol.wire.codec import encode
from protocol.wire.messages import AheadState, BehindState, Handover, Odometry, Phase
from protocol.wire.view import SEEN_BYTES_MAX, Counters
from tests.support.stages.strand_stage import (
    HEARTBEAT_S,
    MISSION,
    ORDER,
    PLACES,
    behind,
    fence_all,
    own,
    place,
    queue_path,
    queued,
    told_behind,
)

LEADER, TAIL = ORDER[0], ORDER[-1]

actions = st.lists(
    st.one_of(
        st.just(("plan", 0, False)),
        st.tuples(st.just("tell"), st.sampled_from(ORDER), st.just(False)),
        st.tuples(st.just("deliver"), st.integers(0, 50), st.booleans()),
        st.tuples(st.just("deliver"), st.integers(0, 50), st.booleans()),
    ),
    max_size=60,
)


class Stage:
    """The robots' parts and memories, and the messages in transit."""

    def __init__(self) -> None:
        self.now_s = 0.0
        self.memories = {robot: Memory(MISSION) for robot in ORDER}
        self.members: dict[int, Member] = {}
        for robot in ORDER:
            driver = Driver(speed_mps=MISSION.speed_mps)
            driver.hear(
                Odometry(
                    n=1,
                    t_s=0.0,
                    pose=PLACES[robot],
                    moving=False,
                    finished=0,
                    fence=fence_all(),
                    phase=Phase.RUNNING,
                )
            )
            self.members[robot] = Member(
                robot,
                mission=MISSION,
                driver=driver,
                senses=Senses(MISSION, driver),
                memory=self.memories[robot],
                formation=queued(robot),
                path=queue_path(ORDER, PLACES),
                now_s=0.0,
            )
        self.leader = self.memories[LEADER].leader(PLACES[LEADER])
        self.handed_on = [self.memories[LEADER].handover]
        self.on_their_way: list[tuple[int, LinkHeard]] = []
        self._numbers: Counter[tuple[int, int]] = Counter()

    def act(self, what: str, which: int, again: bool) -> None:
        match what:
            case "plan":
                self.plan()
            case "tell":
                self.tell(which)
            case _:
                self.deliver(which, again=again)

    def plan(self) -> None:
        """The leader plans some step; which one does not matter here."""
        self.leader.count_on(self.leader.steps + 1)
        self.leader.map.remember(np.array([[float(self.leader.steps), 1.0]]))
        (behind,) = self.members[LEADER].strand.links
        acknowledged = behind.state.handed if isinstance(behind.state, BehindState) else 0
        self.memories[LEADER].hand_on(acknowledged)
        self.handed_on.append(self.memories[LEADER].handover)

    def tell(self, robot: int) -> None:
        self.now_s += HEARTBEAT_S
        for command in self.members[robot].act(self.now_s):
            if isinstance(command, Tell):
                self._numbers[robot, command.robot] += 1
                heard = LinkHeard(robot, self._numbers[robot, command.robot], command.state)
                self.on_their_way.append((command.robot, heard))

    def deliver(self, index: int, *, again: bool) -> None:
        """Deliver a message in transit; `again` leaves it in transit, so that it arrives again."""
        if self.on_their_way:
            at = index % len(self.on_their_way)
            receiver, heard = self.on_their_way[at] if again else self.on_their_way.pop(at)
            self.members[receiver].hear(heard, self.now_s)

    def settle(self) -> None:
        """Lose all messages in transit, and none from then on."""
        self.on_their_way.clear()
        for _ in range(2 * len(ORDER)):  # there and back along all links
            for robot in ORDER:
                self.tell(robot)
            while self.on_their_way:
                self.deliver(0, again=False)

    def check(self) -> None:
        numbers = [self.memories[robot].handover.number for robot in ORDER]
        assert all(ahead_has >= behind_has for ahead_has, behind_has in pairwise(numbers))
        for memory in self.memories.values():
            assert memory.handover == self.handed_on[memory.handover.number]


@given(actions)
@settings(deadline=None)
def test_each_robot_only_has_what_the_leader_handed_over_and_not_before_the_robot_ahead(
    happening: list[tuple[str, int, bool]],
) -> None:
    stage = Stage()
    had = dict.fromkeys(ORDER, 0)
    for action in happening:
        stage.act(*action)
        stage.check()
        has = {robot: stage.memories[robot].handover.number for robot in ORDER}
        assert all(has[robot] >= had[robot] for robot in ORDER), "no robot goes back to an older hand-over"
        had = has


@given(actions)
@settings(deadline=None)
def test_when_messages_arrive_again_all_get_the_newest_and_then_sending_ends(
    happening: list[tuple[str, int, bool]],
) -> None:
    stage = Stage()
    for action in happening:
        stage.act(*action)
    stage.settle()
    newest = stage.handed_on[-1]
    assert [memory.handover for memory in stage.memories.values()] == [newest] * len(ORDER)
    for robot in ORDER:
        stage.tell(robot)
    told = [heard.state for _, heard in stage.on_their_way]
    assert [state.handed for state in told if isinstance(state, AheadState)] == [None, None]


def test_a_successor_continues_the_count_of_steps_and_knows_what_the_leader_saw() -> None:
    stage = Stage()
    for _ in range(3):
        stage.plan()
    stage.settle()
    successor = stage.memories[TAIL].leader(PLACES[TAIL])
    assert successor.steps == 3
    assert successor.map.packed() == stage.leader.map.packed()
    stage.memories[TAIL].hand_on(0)
    assert stage.memories[TAIL].handover.number == stage.memories[LEADER].handover.number + 1


def handover(number: int, seen: bytes = b"") -> Handover:
    return Handover(number=number, steps=number, seen=seen)


def test_a_hand_over_is_sent_at_once_and_on_every_heartbeat_until_it_is_acknowledged() -> None:
    strand, handed = place(2), handover(4)
    strand.tell(own(1.0), 0.0)
    strand.hear(LinkHeard(1, 1, behind(1)), 0.0)
    told = [told_behind(strand.tell(own(1.0, handed=handed), now_s), 1).handed for now_s in (0.01, 1.0, 2.0)]
    strand.hear(LinkHeard(1, 2, behind(1, handed=4)), 2.1)
    told.append(told_behind(strand.tell(own(1.0, handed=handed), 3.0), 1).handed)
    assert told == [handed, handed, handed, None]


def test_a_hand_over_is_sent_only_after_the_robot_behind_has_reported_what_it_has() -> None:
    assert told_behind(place(2).tell(own(1.0, handed=handover(4)), 0.0), 1).handed is None


def test_the_newest_hand_over_is_kept() -> None:
    memory = Memory(MISSION)
    for number in (2, 5, 3):
        memory.succeed(handover(number))
    assert memory.handover == handover(5)


def test_a_new_leader_numbers_its_hand_over_above_those_that_robots_behind_have_had() -> None:
    memory = Memory(MISSION)
    memory.leader(PLACES[LEADER])
    memory.hand_on(7)
    assert memory.handover.number == 8


def test_a_state_always_fits_into_a_message_even_with_a_large_map() -> None:
    strand = place(2)
    strand.hear(LinkHeard(1, 1, behind(1)), 0.0)
    state = told_behind(strand.tell(own(1.0, handed=handover(4, bytes(SEEN_BYTES_MAX))), 1.0), 1)
    assert encode(state, 1)


def test_a_formation_tells_its_leader_the_newest_map_unless_it_has_a_newer_one() -> None:
    memory, seen = Memory(MISSION), []
    for number, told in ((3, b"three"), (5, b"five"), (4, b"four")):
        counters = Counters(steps=number)
        memory.take(replace(queued(LEADER), map_number=number, seen=told, counters=counters))
        seen.append((memory.number, memory.seen, memory.steps))
    assert seen == [(3, b"three", 3), (5, b"five", 5), (5, b"five", 5)]


def test_a_member_that_is_no_leader_keeps_the_map_that_it_has() -> None:
    memory = Memory(MISSION)
    memory.succeed(handover(2, b"two"))
    memory.take(replace(queued(TAIL), map_number=5, counters=Counters(steps=9)))
    assert (memory.number, memory.seen, memory.steps) == (2, b"two", 9)
