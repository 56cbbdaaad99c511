"""After the faults all robots that live form a strand and drive; where they do not, that is found."""

import pytest
from msgspec.structs import replace

from clew.explore import recovering
from clew.explore.explore import explore
from clew.explore.search import Ended
from clew.explore.setting import NEVER_TICKS, SETTINGS, Kind

HEAL = replace(SETTINGS["heal"], deliveries=2, kinds=(Kind.LOSE, Kind.KILL), restarts_ticks=(10, NEVER_TICKS))


def test_with_any_fault_while_a_leader_is_missed_all_that_live_form_a_strand_and_drive() -> None:
    *_, last = explore(HEAL, 1, 60.0, recovers=True)
    assert (last.explored.ended, last.explored.broken) == (Ended.COMPLETE, None)
    assert last.slowest_s is not None
    assert 0.0 < last.slowest_s < 30.0


def test_a_fleet_that_does_not_recover_is_found(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(recovering, "RECOVERS_S", 5.0)
    monkeypatch.setattr("agents.liveness.raising.Raising.want", lambda *_: [])
    begun = replace(HEAL, before=())
    *_, clean = explore(begun, 0, 60.0, recovers=True)
    assert clean.explored.broken is not None, "nobody proposes the first view"
    assert clean.explored.broken.promise == "recovery"
