import os
import subprocess
import sys

import pytest

from clew.guided.forks import in_a_fork
from protocol.root import ROOT
from tests.support.deadline import DEADLINE_S

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


NEVER_ENDS = """
import signal
from clew.guided.forks import in_a_fork

def work():
    print("here", flush=True)
    signal.pause()

in_a_fork(work)
"""


def test_a_fork_ends_with_its_parent_however_that_ends() -> None:
    command, pipe = [sys.executable, "-c", NEVER_ENDS], subprocess.PIPE
    with subprocess.Popen(command, cwd=ROOT, stdout=pipe) as parent:
        assert parent.stdout is not None
        assert parent.stdout.readline() == b"here\n"
        parent.kill()
        # The fork has the same stdout, so its end of file comes only when both have ended.
        parent.communicate(timeout=DEADLINE_S)
