"""The notebook of the docs runs, and shows what it says."""

from pathlib import Path

import pytest

from tests.support.notebook import cells, played


@pytest.mark.long
def test_every_cell_of_the_notebook_runs(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    pytest.importorskip("pandas", reason="the notebook shows frames of pandas, the extra `frames`")
    monkeypatch.chdir(tmp_path)
    code = [cell for cell in cells() if cell["cell_type"] == "code"]
    shown = list(played("".join(cell["source"]) for cell in code))
    assert "<svg" in "".join(shown[0][0]["data"]["text/html"])
    assert "image/png" in shown[2][-1]["data"]
    assert shown[-1][0]["text"] == ["True True\n"]
    assert all(cell["outputs"] for cell in code)  # kept, for those who only read
