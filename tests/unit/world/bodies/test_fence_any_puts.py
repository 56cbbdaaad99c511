"""The register of the fence: what no sequence of puts and starts of the world can do."""

import itertools
from dataclasses import dataclass

from hypothesis import given, settings
from hypothesis import strategies as st

from protocol.fence import Cause, Change, Epoch, Fence, May, Raise, Release, Stop, Turn
from tests.support.registers import ROBOTS, life_of, raised
from tests.support.strategies.examples import examples
from world.bodies.fence import Register

robots = st.integers(0, ROBOTS + 1)
generations = st.integers(0, 6)
starts = st.integers(0, 2)
epochs = st.builds(
    lambda generation, robot, start: Epoch(
        generation=generation, robot=robot, life=start and life_of(robot, start)
    ),
    generations,
    robots,
    starts,
)
fences = st.builds(
    Fence,
    epoch=epochs,
    turn=st.integers(0, 4),
    may=st.sampled_from(May),
    robot=robots,
    life=st.integers(0, 2),
    members=st.integers(0, ROBOTS + 1),
)
changes = (
    st.builds(Raise, epoch=epochs, cause=st.sampled_from(Cause))
    | st.builds(Turn, fence=fences)
    | st.builds(Stop)
    | st.builds(Release, generation=generations)
)


@dataclass(frozen=True)
class Likely:
    """A put that fits the fence in force, so that long ways are found: what a robot would put next."""

    robot: int
    start: int
    may: May
    has_life: bool
    """Whether a turn for one robot names a life of it; no process has life 0."""

    def change(self, now: Fence) -> Change:
        if self.may is May.STOPPED:
            return raised(now.epoch.generation + 1, self.robot, start=self.start)
        named = self.robot if self.may is not May.NOBODY else 0
        return Turn(
            fence=Fence(
                epoch=now.epoch,
                turn=now.turn + 1,
                may=self.may,
                robot=named,
                life=life_of(named) if self.may is May.ONE and self.has_life else 0,
                members=ROBOTS if self.may is May.ALL else 0,
            )
        )


likely = st.builds(Likely, st.integers(1, ROBOTS), st.integers(1, 2), st.sampled_from(May), st.booleans())
puts = st.lists(st.tuples(robots, changes | likely) | st.none(), max_size=30)


def history(said: list[tuple[int, Change | Likely] | None]) -> list[Fence]:
    """All fences that these puts and starts of the world (None) lead to."""
    register = Register(ROBOTS)
    fences = [register.fence]
    for each in said:
        if each is None:
            register.restart(now_s=0.0)
        else:
            robot, change = each
            if isinstance(change, Likely):
                raises = change.may is May.STOPPED
                robot = change.robot if raises else register.fence.epoch.robot
                change = change.change(register.fence)
            register.put(robot, change, now_s=0.0)
        fences.append(register.fence)
    return fences


thoroughly = settings(max_examples=examples(300), deadline=None)


@thoroughly
@given(puts)
def test_nothing_goes_back_and_each_number_has_one_content(
    said: list[tuple[int, Change | Likely] | None],
) -> None:
    fences = history(said)
    contents = {fence.key: fence for fence in fences}
    for before, after in itertools.pairwise(fences):
        assert after.key > before.key or after == before
        assert after.epoch.generation <= before.epoch.generation + 1
    assert all(contents[fence.key] == fence for fence in fences)


@thoroughly
@given(puts)
def test_every_epoch_begins_with_nobody_or_a_stop_and_ends_with_all_or_never_forms(
    said: list[tuple[int, Change | Likely] | None],
) -> None:
    fences = history(said)
    for before, after in itertools.pairwise(fences):
        if after.epoch != before.epoch:
            assert after.turn == 0
            assert after.may in {May.NOBODY, May.STOPPED}
        elif after != before:
            assert after.turn == before.turn + 1
            assert before.may in {May.NOBODY, May.ONE}
            assert after.may is not May.STOPPED


@thoroughly
@given(puts)
def test_before_all_at_most_one_robot_may_move_and_no_life_but_the_one_that_is_named(
    said: list[tuple[int, Change | Likely] | None],
) -> None:
    for fence in history(said):
        lives = [(robot, life_of(robot, start)) for robot in range(1, ROBOTS + 1) for start in (1, 2)]
        may_move = [each for each in lives if fence.names(*each)]
        assert fence.may is May.ALL or len(may_move) <= 1
        assert fence.may is not May.ONE or (1 <= fence.robot <= ROBOTS and fence.life != 0)
