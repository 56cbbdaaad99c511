"""What one environment serves for: the one for tests also draws figures, and that one also runs fleets."""

import subprocess

import pytest

from protocol.root import ROOT

LEVELS = ("run", "tools", "dev")


@pytest.mark.parametrize("made_for", LEVELS)
def test_an_environment_serves_for_what_needs_less(made_for: str) -> None:
    asks = "; ".join(f"clew_holds {made_for} {each} && echo {each}" for each in LEVELS)
    said = subprocess.run(
        ["bash", "-c", f"source launch/setup.sh; {asks}; true"],
        cwd=ROOT,
        capture_output=True,
        text=True,
        check=True,
    )
    assert said.stdout.split() == list(LEVELS[: LEVELS.index(made_for) + 1])
