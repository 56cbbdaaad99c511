"""`log check`: whether the last entries of robots are there, and whether the verdict is of the log."""

from pathlib import Path

import pytest
from msgspec.structs import replace

from clew.log.check import Finding, check
from clew.log.log import Log
from protocol.timeline import (
    AuthorityGranted,
    Record,
    RobotAppeared,
    RobotDied,
    RobotRestarted,
    RobotReturned,
    RobotStarted,
    TrafficCounted,
)
from tests.support.logs.logs import AT_REST, GOOD, numbered, recorded
from world.judge.verdict import VERDICT_FILE
from world.record.run_files import save_verdict

Said = tuple[str, Record]

CAME: Said = ("world", RobotAppeared(robot=3, incarnation="a"))
DIED: Said = ("world", RobotDied(robot=3, silent_since_s=0.0))
BACK: Said = ("world", RobotReturned(robot=3))
AGAIN: Said = ("world", RobotRestarted(robot=3, incarnation="b"))
BEGAN: Said = ("r3", RobotStarted(pid=1, incarnation="a"))
LAST: Said = ("r3", TrafficCounted(sent={}, received={}, newest={}, refused={}, overflowed=0, unrecorded=0))
LOST = ("r3: its last entries are missing: the one in which it has counted messages",)


@pytest.mark.parametrize(
    ("told", "flaws"),
    [
        ((CAME, BEGAN, LAST), ()),
        ((CAME, BEGAN), LOST),
        ((CAME,), LOST),
        ((CAME, BEGAN, DIED), ()),
        ((CAME, BEGAN, DIED, BACK), LOST),
        ((CAME, BEGAN, DIED, BACK, LAST), ()),
        ((CAME, BEGAN, LAST, DIED, AGAIN), LOST),
        ((CAME, BEGAN, ("r2", DIED[1])), LOST),
    ],
)
def test_when_a_run_has_ended_each_robot_that_is_there_has_told_its_last_entry(
    tmp_path: Path, told: tuple[Said, ...], flaws: tuple[str, ...]
) -> None:
    lines = numbered((*AT_REST[:-1], *told, AT_REST[-1]))
    assert (
        tuple(each for each in check(Log(recorded(tmp_path / "run", lines))).flaws if "last" in each) == flaws
    )


def test_of_a_run_that_has_not_ended_more_entries_may_come(tmp_path: Path) -> None:
    lines = numbered((*AT_REST[:-1], CAME, BEGAN))
    assert not any("last entries" in each for each in check(Log(recorded(tmp_path / "run", lines))).flaws)


def test_what_waits_for_entries_that_a_cut_log_has_not_is_broken_only_if_the_run_has_ended(
    tmp_path: Path,
) -> None:
    granted: Said = ("r3", AuthorityGranted(to=4, authority_m=1.0, epoch=1))
    ended = numbered((*AT_REST[:-1], granted, AT_REST[-1]))
    assert check(Log(recorded(tmp_path / "ended", ended))).violations > 0
    cut_off = check(Log(recorded(tmp_path / "cut", ended[:-1])))
    assert not cut_off.ok
    assert cut_off.violations == 0


def test_what_the_world_has_found_broken_at_the_end_is_found_again_without_its_last_entry(
    tmp_path: Path,
) -> None:
    granted: Said = ("r3", AuthorityGranted(to=4, authority_m=1.0, epoch=1))
    ended = numbered((*AT_REST[:-1], granted, AT_REST[-1]))
    found = check(Log(recorded(tmp_path / "found", ended))).breaches
    broken = [("world", replace(ended[-1][1], record=each.broken)) for each in found]
    t_s = ended[-2][1].t_s  # so that nothing shows before the end that no other entry of this time comes
    told = [(source, replace(entry, n=n, t_s=t_s)) for n, (source, entry) in enumerate(broken, start=6)]
    cut_off = check(Log(recorded(tmp_path / "cut", [*ended[:-1], *told])))
    assert cut_off.violations == len(found) > 0
    assert not any("not found again" in each for each in cut_off.flaws)


def judged(folder: Path, **said: object) -> Finding:
    """What is found in a log where nothing moved, beside a verdict that says this."""
    run = recorded(folder, numbered(AT_REST))
    finding = check(Log(run))
    shared = {name: getattr(finding, name) for name in Finding.__struct_fields__ if hasattr(GOOD, name)}
    shared.pop("ok")
    save_verdict(replace(GOOD, **{**shared, **said}), folder)
    return check(Log(run))


@pytest.mark.parametrize(
    ("said", "flaw"),
    [
        ({}, None),
        ({"clearance_m_min": 0.5}, "clearance_m_min is 0.5, by the log "),
        ({"clearance_m_min": None}, "clearance_m_min is None, by the log "),
        ({"moving_clearance_m_min": 0.5}, "moving_clearance_m_min is 0.5, by the log None"),
        ({"separation_m_min": 0.2}, "separation_m_min is 0.2, by the log "),
        ({"clearance_m_required": 0.1}, "clearance_m_required is 0.1, by the log 0.0"),
        ({"path_m": 7.0}, "path_m is 7.0, by the log 0.0"),
        ({"violations_by_invariant": {"F5": 2}}, "violations: F5 (authority) 2, by the log none"),
        ({"violations": 2}, "is ok and has 2 violations"),
    ],
)
def test_a_verdict_that_says_something_else_than_its_log_is_found(
    tmp_path: Path, said: dict[str, object], flaw: str | None
) -> None:
    flaws = judged(tmp_path / "run", **said).flaws
    assert len(flaws) == (flaw is not None)
    assert all(each.startswith(f"{VERDICT_FILE}: {flaw}") for each in flaws)


def test_a_verdict_that_cannot_be_read_is_found_and_one_of_a_run_that_nobody_judged_is_none(
    tmp_path: Path,
) -> None:
    nobody = {"ok": False, "sim_s": 0.0, "clearance_m_min": None, "separation_m_min": None}
    assert judged(tmp_path / "run", **nobody).flaws == ()
    (tmp_path / "run" / VERDICT_FILE).write_text("{}")
    (flaw,) = check(Log(tmp_path / "run")).flaws
    assert flaw.startswith(f"{VERDICT_FILE} cannot be read: ")
    (tmp_path / "run" / VERDICT_FILE).unlink()
    (tmp_path / "run" / VERDICT_FILE).mkdir()
    assert check(Log(tmp_path / "run")).flaws == (f"{VERDICT_FILE} cannot be read: Is a directory",)
