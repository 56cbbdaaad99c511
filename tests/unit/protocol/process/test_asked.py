"""Signals ask verbs to end: at once or at a convenient point, and only once."""

import signal
from collections.abc import Iterator
from pathlib import Path
from types import FrameType

import pytest

from protocol.process.asked import EXIT_CODES, AskedToEnd, asked_to_end, terminable
from tests.support.campaigns import clew


@pytest.fixture(autouse=True)
def handlers() -> Iterator[None]:
    """Restores all signal handlers after a test."""
    before = {number: signal.signal(number, unheard) for number in EXIT_CODES}
    yield
    left = {signal.getsignal(number) for number in EXIT_CODES}
    for number, handler in before.items():
        signal.signal(number, handler)
    assert left == {unheard}


def unheard(number: int, _frame: FrameType | None) -> None:
    pytest.fail(f"nobody heard signal {number}")


@pytest.mark.parametrize("number", EXIT_CODES)
def test_a_signal_ends_terminable_code_like_ctrl_c_with_128_plus_its_number(number: int) -> None:
    with pytest.raises(KeyboardInterrupt) as raised, terminable():
        signal.raise_signal(number)
    assert isinstance(raised.value, AskedToEnd)
    assert raised.value.exit_code == 128 + number


@terminable()
def ended_twice(done: list[str]) -> None:
    try:
        signal.raise_signal(signal.SIGTERM)
    finally:
        signal.raise_signal(signal.SIGTERM)
        done.append("tidied up")


def test_a_second_signal_does_not_disturb_the_end_and_the_next_call_reacts_again() -> None:
    done: list[str] = []
    for _ in range(2):
        with pytest.raises(AskedToEnd):
            ended_twice(done)
    assert done == ["tidied up"] * 2


def test_asked_to_end_only_reports_a_signal_even_inside_terminable_code() -> None:
    with terminable(), asked_to_end() as asked:
        signal.raise_signal(signal.SIGHUP)
        signal.raise_signal(signal.SIGINT)
        assert asked == [129, 130]


def test_ignored_signals_stay_ignored() -> None:
    before = signal.signal(signal.SIGHUP, signal.SIG_IGN)  # like nohup
    try:
        with terminable(), asked_to_end() as asked:
            signal.raise_signal(signal.SIGHUP)
            assert asked == []
    finally:
        signal.signal(signal.SIGHUP, before)


@pytest.mark.parametrize(
    ("verb", "module"),
    [
        (("chaos", "--out", "ch"), "clew.verbs.chaos.run_fleet"),
        (("bench", "healing"), "clew.verbs.bench_healing.run_fleet"),
        (("bench", "loss", "--live", "1"), "clew.bench.loss.rehearsed"),
    ],
)
def test_a_verb_that_runs_fleets_ends_between_them_with_the_signals_code(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, verb: tuple[str, ...], module: str
) -> None:
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr(module, lambda *_, **__: signal.raise_signal(signal.SIGTERM))
    assert clew(*verb).exit_code == 143
