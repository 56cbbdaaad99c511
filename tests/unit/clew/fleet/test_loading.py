"""What a fleet's processes load before a robot can start."""

import pytest

from tests.support.processes.loading import loaded


@pytest.mark.parametrize(
    ("process", "unused"),
    [
        ("world.__main__", "scipy"),
        ("clew.fleet.shell", "scipy"),
        ("agents.process.host", "scipy.ndimage"),
    ],
)
def test_no_process_of_a_fleet_loads_a_slow_library_that_it_seldom_needs(process: str, unused: str) -> None:
    assert unused not in loaded(f"import {process}")
