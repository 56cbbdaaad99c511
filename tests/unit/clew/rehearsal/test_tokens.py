"""Liveliness tokens in rehearsal: which process sees which token, and when that changes."""

from collections.abc import Iterable, Iterator

from hypothesis import given
from hypothesis import strategies as st

from clew.rehearsal.tokens import Change, FirstLook, Tokens


def fleet(robots: int = 3) -> Tokens:
    tokens = Tokens()
    for process in range(robots + 1):
        tokens.show(process, "1")
    tokens.changes(0.0)
    return tokens


def one_by_one(changes: Iterable[Change | FirstLook]) -> Iterator[Change]:
    for change in changes:
        if isinstance(change, FirstLook):
            yield from (Change(change.observer, *each, came=True) for each in change.shown.items())
        else:
            yield change


def said(changes: list[Change | FirstLook]) -> list[str]:
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


def test_a_first_look_is_one_change_for_each_process() -> None:
    tokens = Tokens()
    for process in range(3):
        tokens.show(process, "1")
    assert [type(change) for change in tokens.changes(0.0)] == [FirstLook] * 3
