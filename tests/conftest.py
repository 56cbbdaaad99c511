"""What holds for all tests."""

import gc
import os
import signal
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import pytest
from hypothesis import HealthCheck, settings

from tests.support.processes.fleets import Fleet
from tests.support.runs import Runs

# No claim here is about time, and on a loaded machine any single example may take longer than 200 ms, and the
# making of ten of them longer than 30 s.
# What lands must not hang on luck, so under CI the examples are always the same; elsewhere they are new.
# `launch/test.sh --long` tries three times as many, `pytest --hypothesis-profile=thorough` far more.
TIMELESS = settings(deadline=None, suppress_health_check=[HealthCheck.too_slow])
settings.register_profile("clew", TIMELESS, max_examples=15, derandomize="CI" in os.environ)
settings.register_profile("long", TIMELESS, max_examples=50, derandomize="CI" in os.environ)
settings.register_profile("thorough", TIMELESS, max_examples=1000)
settings.load_profile("clew")

# A shell's job in the background ignores the interrupt, and so would every process that a test starts.
signal.signal(signal.SIGINT, signal.default_int_handler)
# `nohup` ignores the hangup likewise. A handler in its place is not passed on to processes that tests start.
if signal.getsignal(signal.SIGHUP) is signal.SIG_IGN:
    signal.signal(signal.SIGHUP, lambda _number, _frame: None)

# Python looks for cycles whenever 700 objects more live. To collect the tests makes millions that stay:
# it takes 3.7 s of CPU with this threshold, and 5.0 s with Python's own.
gc.set_threshold(20_000, 50, 50)


class FailuresAtOnce:
    """Says what failed when it fails: a run that is ended from outside never comes to its summary."""

    def __init__(self, terminal: pytest.TerminalReporter) -> None:
        self._terminal = terminal

    def pytest_runtest_logreport(self, report: pytest.TestReport) -> None:
        if report.failed:
            self._terminal.write_line(f"\nFAILED {report.nodeid} ({report.when})\n{report.longreprtext}")


@pytest.hookimpl(trylast=True)  # the reporter is registered by a hook of its own
def pytest_configure(config: pytest.Config) -> None:
    terminal = config.pluginmanager.get_plugin("terminalreporter")
    if isinstance(terminal, pytest.TerminalReporter):  # the workers of xdist have none
        config.pluginmanager.register(FailuresAtOnce(terminal))


def pytest_collection_finish() -> None:
    gc.freeze()  # else each full collection walks all that was collected: 5 % of the tests' time


@pytest.fixture
def held() -> Callable[[type], list[Any]]:
    """Lists the instances of a type that were made since the test began, and live."""
    gc.freeze()  # else each list walks all that former tests keep

    def instances(kind: type) -> list[Any]:
        gc.collect()
        return [each for each in gc.get_objects() if isinstance(each, kind)]

    return instances


@pytest.fixture(scope="session")
def runs(tmp_path_factory: pytest.TempPathFactory) -> Runs:
    """Runs to read, each rehearsed once for all workers."""
    base = tmp_path_factory.getbasetemp()
    folder = (base.parent if "PYTEST_XDIST_WORKER" in os.environ else base) / "runs"
    folder.mkdir(exist_ok=True)
    return Runs(folder)


@pytest.fixture
def fleet(tmp_path: Path) -> Iterator[Fleet]:
    """Real processes, of which none is left when the test is over."""
    fleet = Fleet(tmp_path)
    yield fleet
    fleet.destroy()
