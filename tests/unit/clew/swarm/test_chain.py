import msgspec
import pytest

from clew.rehearsal.rehearsal import Rehearsal
from clew.swarm import chain
from clew.swarm.chain import play_chain
from clew.swarm.draws import Draws
from clew.swarm.futures import HORIZON_S, Branches, draw_future
from clew.swarm.swarm import draw
from protocol.timeline import FenceChanged
from tests.support.long import long
from world.bodies.arena import TICK_S

SEEDS = [3, *long((1, 2, 4, 5, 12))]


def begin(seed: int, branches: Branches = ()) -> Rehearsal:
    future = draw_future(seed, branches)
    return Rehearsal(future.scenario, seed, future.plan)


def played(seed: int) -> tuple[Rehearsal, Branches]:
    """The run of a seed, and all its branches."""
    run, branches = begin(seed), Branches()
    for branches, _ in play_chain(run, draw_future(seed, ())):  # noqa: B007 - the last are wanted
        pass
    return run, branches


def timeline(run: Rehearsal) -> bytes:
    return msgspec.json.encode(run.entries)


@pytest.mark.parametrize("seed", SEEDS)
def test_a_chain_is_the_future_with_its_branches_to_the_byte_and_ends_soon_after_the_last(seed: int) -> None:
    run, branches = played(seed)
    assert len(branches) > 1
    assert timeline(run) == timeline(begin(seed, branches).run())
    assert branches[-1].from_s < run.world.now_s < branches[-1].from_s + HORIZON_S + 3.0


@pytest.mark.parametrize("seed", SEEDS)
def test_strikes_begin_at_the_start_and_where_the_fence_has_a_new_epoch_and_on_who_coordinates_it(
    seed: int,
) -> None:
    run, (first, *others) = played(seed)
    raised = [
        (entry.t_s, entry.record.coordinator)
        for _, entry in run.entries
        if isinstance(entry.record, FenceChanged) and entry.record.turn == 0
    ]
    assert first.from_s == pytest.approx(TICK_S + 0.001)
    assert others
    for branch in others:
        assert any(
            t_s <= branch.from_s <= t_s + 2 * TICK_S and robot in (branch.robot, 0) for t_s, robot in raised
        )


def test_the_seed_draws_whether_it_is_struck_and_some_are_not() -> None:
    plain = [seed for seed in range(1, 201) if Draws(seed, "chain").chance(chain.PLAIN)]
    assert 1 < len(plain) < 25


def test_a_seed_that_is_never_struck_is_its_own_episode(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(chain, "PLAIN", 1.0)
    run, branches = played(12)
    own = draw(12)
    assert branches == ()
    assert timeline(run) == timeline(Rehearsal(own.scenario, 12, own.plan).run())


def test_a_chain_has_no_more_than_so_many_strikes(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(chain, "STRIKES_MAX", 1)
    assert len(played(12)[1]) == 1
