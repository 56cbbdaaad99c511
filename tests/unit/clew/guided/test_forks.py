import os

import pytest

from clew.guided.forks import in_a_fork

pytestmark = pytest.mark.usefixtures("no_child_is_left")


def test_a_fork_hands_back_what_it_returns_and_changes_nothing_here() -> None:
    here = [1]

    def work() -> bytes:
        here.append(2)
        return bytes(here) * 100_000  # more than a pipe holds

    assert in_a_fork(work) == b"\x01\x02" * 100_000
    assert here == [1]


def test_a_fork_that_dies_or_fails_hands_back_nothing() -> None:
    def fail() -> bytes:
        raise ValueError

    assert in_a_fork(lambda: os._exit(3)) is None
    assert in_a_fork(fail) is None


def test_a_fork_may_fork() -> None:
    assert in_a_fork(lambda: (in_a_fork(lambda: b"inner") or b"") + b" and outer") == b"inner and outer"
