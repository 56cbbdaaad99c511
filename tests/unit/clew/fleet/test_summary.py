from pathlib import Path

import msgspec
import pytest

from clew.fleet.summary import (
    figures_line,
    recovery_lines,
    rms_line,
    summary_of,
    table_lines,
    verdict_sentence,
)
from protocol.errors import UsageError
from tests.support.logs.logs import AT_REST, GOOD, PAPER, numbered, recorded
from world.judge.recovery import Death, Heal, Succession
from world.scenario.scenario import load


def test_table_is_printed_beside_the_measured_distances() -> None:
    lines = list(table_lines(((1.168, 0.433), (1.125, 0.384)), ((1.17, 0.4),)))
    assert lines[3].split() == ["1", "1.168", "1.170", "0.433", "0.400"]
    assert lines[4].split() == ["2", "1.125", "-", "0.384", "-"]
    assert len({len(line) for line in lines[1:]}) == 1


def test_rms_is_printed_or_the_reason_why_there_is_none() -> None:
    assert PAPER.table_m is not None
    assert rms_line(PAPER.table_m, GOOD) == "RMS error against Table I: 0.0254 m over 33 distances"
    lost = msgspec.structs.replace(GOOD, table_rms_m=None)
    assert "no RMS" in rms_line(PAPER.table_m, lost)


def test_law_without_a_promise_is_compared_with_the_certified_law() -> None:
    sentence = verdict_sentence(GOOD, PAPER)
    assert sentence.startswith("OK: every living robot has arrived; 5 of 5 robots arrived")
    assert "0.0260 m short of the epsilon - mu0 = 0.0900 m that --law certified has to keep" in sentence


def test_law_with_a_promise_is_compared_with_its_promise() -> None:
    kept = msgspec.structs.replace(GOOD, law="certified", clearance_m_min=0.0953, clearance_m_required=0.09)
    sentence = verdict_sentence(kept, load("grove"))
    assert sentence.endswith("clearance 0.0953 m of 0.0900 m required.")


def test_failed_run_begins_with_the_reason() -> None:
    failed = msgspec.structs.replace(GOOD, ok=False, reason="robot 3 died at t=4.2 s", robots_arrived=0)
    assert verdict_sentence(failed, PAPER).startswith("FAILED: robot 3 died at t=4.2 s; 0 of 5 robots")


@pytest.fixture
def run(tmp_path: Path) -> Path:
    folder = recorded(tmp_path / "run", numbered(AT_REST))
    (folder / "verdict.json").write_bytes(msgspec.json.encode(GOOD))
    return folder


def test_last_line_is_the_verdict_and_the_folder(run: Path) -> None:
    last = summary_of(str(run)).splitlines()[-1]
    assert last.startswith("OK: ")
    assert last.endswith(f"Run: {run}")


def test_folder_without_verdict_is_refused(tmp_path: Path) -> None:
    with pytest.raises(UsageError, match=r"verdict\.json"):
        summary_of(str(tmp_path))


def test_faults_and_recoveries_are_printed() -> None:
    death = Death(
        robot=1, ordered=True, cause_s=3.0, detected_s=3.4, known_s=4.1, recovered_s=6.0, returned_s=None
    )
    lost = Death(
        robot=4, ordered=False, cause_s=8.0, detected_s=None, known_s=9.0, recovered_s=None, returned_s=None
    )
    unbroken = msgspec.structs.replace(death, robot=3, detected_s=None)
    frozen = msgspec.structs.replace(death, robot=5, returned_s=9.0)
    succession = Succession(robot=2, before=1, epoch=7, cause_s=3.0, detected_s=3.4, recovered_s=5.0)
    heal = Heal(epoch=7, members=(2, 3), cause_s=3.0, detected_s=3.4, recovered_s=6.0)
    messages = msgspec.structs.replace(GOOD.messages, injected={"drop": 5})
    verdict = msgspec.structs.replace(
        GOOD,
        messages=messages,
        deaths=(death, unbroken, lost, frozen),
        successions=(succession,),
        heals=(heal,),
        unstruck=("drop-2", "late"),
    )
    assert list(recovery_lines(verdict)) == [
        "messages removed by fault rules: 5 by drop",
        "robot 1 died as asked at t=3.0 s: noticed after 0.4 s, healed after 3.0 s",
        "robot 3 died as asked at t=3.0 s: no link to it was broken, healed after 3.0 s",
        "robot 4 died by itself at t=8.0 s: not noticed by any robot",
        "robot 5 was silent from t=3.0 s to t=9.0 s, as asked: noticed after 0.4 s, healed after 3.0 s",
        "robot 2 leads in the place of robot 1 from t=5.0 s on",
        "the strand healed at t=6.0 s, of 2 robots",
        "fault rules that never struck: drop-2, late",
    ]
    assert list(recovery_lines(GOOD)) == []


@pytest.mark.parametrize(
    ("steps", "said"), [(1, "1 switching step finished, "), (2, "2 switching steps finished, ")]
)
def test_finished_steps_are_counted_with_singular_and_plural(steps: int, said: str) -> None:
    assert figures_line(msgspec.structs.replace(GOOD, switching_steps=steps)).startswith(said)
