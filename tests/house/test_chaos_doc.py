import re

from clew.campaign.chaos import Chaos, ChaosRun
from clew.manual.faults import DOCUMENT

PAGE = DOCUMENT.read_text(encoding="utf-8")


def named(heading: str) -> set[str]:
    """What the first column of the table with this heading names."""
    table = PAGE.split(f"\n| {heading} | meaning |\n")[1].split("\n\n")[0]
    rows = re.findall(r"^\| (`.*?) \|", table, re.MULTILINE)
    return {name for row in rows for name in re.findall(r"`(\w+)`", row)}


def test_every_field_of_chaos_and_of_its_runs_is_explained_and_no_other() -> None:
    assert named("field of `chaos.json`") == set(Chaos.__struct_fields__)
    assert named("field of a run") == set(ChaosRun.__struct_fields__)
