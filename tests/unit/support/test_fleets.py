"""What a fleet of a test prints is not lost."""

from pathlib import Path

import pytest

from tests.support.deadline import DEADLINE_S
from tests.support.processes.fleets import Fleet


def test_what_was_printed_is_printed_again_at_the_end_also_if_the_test_has_read_it(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    fleet = Fleet(tmp_path)
    fleet.start_with("sh", "-c", "echo robot 1: lost >&2")
    assert fleet.end(DEADLINE_S).err == "robot 1: lost\n"
    fleet.said.write_text("robot 2: lost\n", encoding="utf-8")
    fleet.destroy()
    assert capsys.readouterr().err == "robot 1: lost\nrobot 2: lost\n"
