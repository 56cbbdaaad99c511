"""Liveliness tokens in rehearsal: which process sees which token, and when that changes."""

from collections.abc import Iterable, Iterator

from hypothesis import given
from hypothesis import strategies as st

from clew.rehearsal.tokens import Change, Look, Seen, Tokens, Watched


def fleet(robots: int = 3) -> Tokens:
    tokens = Tokens()
    for process in range(robots + 1):
        tokens.show(process, "1")
    tokens.changes(0.0)
    return tokens


def one_by_one(changes: Iterable[Seen]) -> Iterator[Change]:
    for change in changes:
        if isinstance(change, Look):
            yield from (Change(change.observer, *each, came=True) for each in change.shown.items())
        elif isinstance(change, Change):
            yield change


def said(changes: list[Seen]) -> list[str]:
    return [
        f"{each.observer}{'+' if each.came else '-'}{each.process}.{each.incarnation}"
        for each in one_by_one(changes)
    ]


def test_at_the_start_each_process_sees_all_tokens_but_its_own() -> None:
    tokens = Tokens()
    for process in range(3):
        tokens.show(process, "1")
    assert said(tokens.changes(0.0)) == ["0+1.1", "0+2.1", "1+0.1", "1+2.1", "2+0.1", "2+1.1"]
    assert tokens.changes(0.1) == []


def test_a_dead_process_loses_its_token_at_once_and_its_successor_has_a_new_one() -> None:
    tokens = fleet()
    tokens.end(2)
    assert said(tokens.changes(1.0)) == ["0-2.1", "1-2.1", "3-2.1"]
    tokens.show(2, "2")
    assert said(tokens.changes(2.0)) == ["0+2.2", "1+2.2", "2+0.1", "2+1.1", "2+3.1", "3+2.2"]


def test_a_restart_between_two_looks_is_reported_as_gone_and_come() -> None:
    tokens = fleet(1)
    tokens.end(1)
    tokens.show(1, "2")
    assert said(tokens.changes(1.0)) == ["0-1.1", "0+1.2", "1+0.1"]


def test_a_frozen_process_loses_its_token_after_the_lease_and_gets_it_back_at_the_thaw() -> None:
    tokens = fleet(2)
    tokens.freeze(1, 5.0)
    assert said(tokens.changes(5.98)) == []
    assert said(tokens.changes(6.0)) == ["0-1.1", "2-1.1"]
    tokens.thaw(1)
    assert said(tokens.changes(9.0)) == ["0+1.1", "2+1.1"]


def test_a_freeze_shorter_than_the_lease_is_not_seen() -> None:
    tokens = fleet(2)
    tokens.freeze(1, 5.0)
    tokens.changes(5.5)
    tokens.thaw(1)
    assert said(tokens.changes(9.0)) == []


def test_a_process_that_is_cut_off_sees_no_token_and_shows_none() -> None:
    tokens = fleet(2)
    tokens.cut({2}, 3.0)
    assert said(tokens.changes(3.9)) == []
    assert said(tokens.changes(4.0)) == ["0-2.1", "1-2.1", "2-0.1", "2-1.1"]
    tokens.cut(set(), 6.0)
    assert said(tokens.changes(6.0)) == ["0+2.1", "1+2.1", "2+0.1", "2+1.1"]


class Stage:
    """Four processes, their faults, and the tokens that each has been told of."""

    def __init__(self) -> None:
        self.tokens = fleet()
        self.living, self.frozen, self.cut = {0, 1, 2, 3}, set[int](), set[int]()
        self.seen = {each: {other: "1" for other in range(4) if other != each} for each in range(4)}
        self._lives = 1

    def do(self, action: str, process: int, at_s: float) -> None:
        match action:
            case "end":
                self.tokens.end(process)
                self.living.discard(process)
                self.seen.pop(process, None)
            case "show" if process not in self.living:
                self._lives += 1
                self.tokens.show(process, str(self._lives))
                self.living.add(process)
                self.frozen.discard(process)
                self.seen[process] = {}
            case "freeze":
                self.tokens.freeze(process, at_s)
                self.frozen.add(process)
            case "thaw":
                self.tokens.thaw(process)
                self.frozen.discard(process)
            case "cut":
                self.cut ^= {process}
                self.tokens.cut(set(self.cut), at_s)
            case _:
                pass  # it is alive already

    def look(self, at_s: float) -> None:
        for change in one_by_one(self.tokens.changes(at_s)):
            told = self.seen[change.observer]
            if change.came:
                told[change.process] = change.incarnation
            else:
                assert told.pop(change.process) == change.incarnation


@given(
    st.lists(st.tuples(st.sampled_from(["end", "show", "freeze", "thaw", "cut"]), st.integers(0, 3))),
    st.sampled_from([0.02, 0.4, 3.0]),
)
def test_after_any_sequence_of_faults_each_process_sees_exactly_the_live_tokens(
    actions: list[tuple[str, int]], every_s: float
) -> None:
    stage = Stage()
    for number, (action, process) in enumerate(actions):
        stage.do(action, process, number * every_s)
        stage.look(number * every_s)
    stage.look(1000.0)
    listed = stage.living - stage.frozen - stage.cut
    expected = {each: set() if each in stage.cut else listed - {each} for each in stage.living}
    assert {each: set(told) for each, told in stage.seen.items()} == expected


def test_a_robot_is_told_of_the_world_and_of_those_that_it_watches_and_when_that_is_all() -> None:
    tokens = Tokens()
    for process in range(5):
        tokens.show(process, "1")
    tokens.watch(2, frozenset({1}))
    assert [each for each in tokens.changes(0.0) if each.observer == 2] == [
        Look(2, {0: "1", 1: "1"}),
        Watched(2, frozenset({1})),
    ]
    tokens.end(4)
    assert said(tokens.changes(1.0)) == ["0-4.1", "1-4.1", "3-4.1"]


def test_what_it_begins_to_watch_it_sees_at_one_look_and_what_it_no_longer_watches_is_forgotten() -> None:
    tokens = fleet(5)
    tokens.watch(2, frozenset({1, 3}))
    assert tokens.changes(1.0) == [Watched(2, frozenset({1, 3}))]
    tokens.end(5)
    tokens.watch(2, frozenset({3, 4}))
    tokens.changes(2.0)
    tokens.watch(2, None)
    assert [each for each in tokens.changes(3.0) if each.observer == 2] == [
        Look(2, {1: "1"}),
        Watched(2, None),
    ]


def test_a_robot_that_is_cut_off_has_seen_all_that_it_can_see_and_sees_the_rest_when_it_is_back() -> None:
    tokens = fleet(3)
    tokens.watch(1, frozenset({2}))
    tokens.cut({1}, 0.0)
    tokens.changes(5.0)
    tokens.watch(1, frozenset({3}))
    assert tokens.changes(6.0) == [Watched(1, frozenset({3}))]
    tokens.cut(set(), 7.0)
    assert [each for each in tokens.changes(7.0) if each.observer == 1] == [Look(1, {0: "1", 3: "1"})]


def test_a_first_look_is_one_change_for_each_process() -> None:
    tokens = Tokens()
    for process in range(3):
        tokens.show(process, "1")
    assert [type(change) for change in tokens.changes(0.0)] == [Look] * 3
