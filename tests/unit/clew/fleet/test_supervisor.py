"""Supervision by replayed histories (tests/support/histories): no process, no clock, no sleep."""

import itertools

import pytest
from hypothesis import given
from hypothesis import strategies as st

from clew.fleet import supervisor
from clew.fleet.supervision import rules
from clew.fleet.supervision.events import (
    HOST,
    TABLE,
    VIEWER,
    WORLD,
    Asked,
    Begun,
    Command,
    Ended,
    Event,
    FaultAsked,
    Judged,
    Ready,
    Start,
    Tick,
)
from clew.fleet.supervision.limits import FLEET, Limits, Plan, limits_of
from clew.fleet.supervision.rules import IGNORED, RULES, Do, Rule, State, What
from clew.fleet.supervisor import ACTIONS, Supervisor
from protocol.exit_codes import ExitCode
from protocol.faults.process_faults import ProcessAction
from tests.support.histories.ends import ENDS
from tests.support.histories.losses import LOSSES
from tests.support.histories.told import R1, R2, replay

HISTORIES = {**LOSSES, **ENDS}


@pytest.mark.parametrize("name", HISTORIES)
def test_the_supervisor_acts_as_in_its_history(name: str) -> None:
    replay(HISTORIES[name])


def test_every_rule_has_a_history(monkeypatch: pytest.MonkeyPatch) -> None:
    applied = set[tuple[State, What]]()

    class Noted(dict[tuple[State, What], Rule]):
        def __getitem__(self, pair: tuple[State, What]) -> Rule:
            applied.add(pair)
            return super().__getitem__(pair)

    monkeypatch.setattr(supervisor, "RULE_FOR", Noted(rules.TABLE))
    for history in HISTORIES.values():
        replay(history)
    acting = {pair for rule in RULES for pair in itertools.product(rule.states, rule.whats)}
    assert acting - applied == set()


@pytest.mark.parametrize(("state", "what"), list(itertools.product(State, What)))
def test_every_pair_has_one_rule(state: State, what: What) -> None:
    found = [rule for rule in RULES if state in rule.states and what in rule.whats]
    assert len(found) <= 1
    rule = rules.TABLE[state, what]
    assert rule == (found[0] if found else Rule((what,), (state,), Do.NOTHING, None, IGNORED[what]))
    assert rule.do in ACTIONS


def test_every_action_serves_a_rule() -> None:
    assert {rule.do for rule in rules.TABLE.values()} == set(ACTIONS) == set(Do)


@pytest.mark.parametrize("state", State)
def test_states_follow_in_one_direction(state: State) -> None:
    order = list(State)
    for (before, _), rule in rules.TABLE.items():
        if before is state and rule.to is not None:
            assert order.index(rule.to) > order.index(state)


def test_a_waiting_state_is_woken_at_its_deadline() -> None:
    supervised = replay(HISTORIES["a part that is frozen for a time is thawed after it"])
    assert supervised.wake_at() is None
    supervised.handle(FaultAsked(ProcessAction.FREEZE, "world", 1.5), 10.0)
    assert supervised.wake_at() == 11.5
    supervised.handle(Asked(ExitCode.TERMINATED), 10.5)
    assert supervised.wake_at() == 11.5
    supervised.handle(Tick(), 11.5)
    assert supervised.wake_at() == 13.5


PARTS = (WORLD, HOST, R1, R2, TABLE, VIEWER)
EVENTS = st.one_of(
    st.builds(Judged, st.sampled_from(ExitCode)),
    st.just(Tick()),
    st.builds(Ready, st.sampled_from((R1, R2, VIEWER))),
    st.builds(Ended, st.sampled_from(PARTS), st.sampled_from((0, 1, 2, -9))),
    st.builds(
        FaultAsked, st.sampled_from(ProcessAction), st.sampled_from(PARTS), st.sampled_from((None, 0.5))
    ),
)


@given(
    plan=st.builds(Plan, routers=st.integers(0, 2), view=st.booleans(), table=st.booleans()),
    events=st.lists(EVENTS, max_size=40),
)
def test_after_any_history_a_request_to_end_is_met_in_time_even_if_no_part_reacts(
    plan: Plan, events: list[Event]
) -> None:
    supervised, now_s = Supervisor(plan), 0.0
    running = started(supervised.handle(Begun(), now_s))
    for event in events:
        now_s += 0.1
        if isinstance(event, Ended | Ready) and event.part not in running:
            continue  # a part that does not run sends no events
        commands = supervised.handle(event, now_s)
        if isinstance(event, Ended):
            running.discard(event.part)
        running |= started(commands)
    asked_s = now_s
    commands = supervised.handle(Asked(ExitCode.INTERRUPTED), now_s)
    while supervised.state is not State.OVER:
        wake_at = supervised.wake_at()
        assert wake_at is not None
        assert wake_at <= asked_s + Limits().all_s + 1e-9
        now_s = max(now_s, wake_at)
        commands = supervised.handle(Tick(), now_s)
        assert started(commands) == set()
    assert supervised.handle(Begun(), now_s) == []
    assert supervised.wake_at() is None


def started(commands: list[Command]) -> set[str]:
    return {command.part for command in commands if isinstance(command, Start)}


@pytest.mark.parametrize(
    ("limits", "complaint"),
    [
        ({"all_s": 3.8}, r"all_s must exceed .* \(3.8\), got 3.8"),
        ({"grace_s": 4.0}, r"all_s must exceed .* \(4.8\), got 4.8"),
    ],
)
def test_inconsistent_limits_are_refused(limits: dict[str, float], complaint: str) -> None:
    with pytest.raises(ValueError, match=complaint):
        Limits(**limits)  # type: ignore[arg-type]  # all of these are floats


def test_a_large_fleet_has_more_time_to_end_in_proportion() -> None:
    assert limits_of(FLEET, is_resumable=True) == Limits()
    large = limits_of(5 * FLEET, is_resumable=True)
    assert (large.world_s, large.all_s) == (5.0 * Limits().world_s, 5.0 * Limits().all_s)
    assert large.ready_s == Limits().ready_s, "a router's start does not depend on robots"


def test_a_world_of_many_fleets_has_time_to_judge_them_one_after_the_other() -> None:
    alone, many = (limits_of(5 * FLEET, fleets=fleets, is_resumable=False) for fleets in (0, FLEET))
    assert many.world_s == 2.0 * alone.world_s
    assert limits_of(12, fleets=4, is_resumable=False).world_s == Limits().world_s


def test_a_world_that_cannot_be_resumed_is_not_started_again() -> None:
    assert limits_of(5, is_resumable=False).world_restarts_max == 0
