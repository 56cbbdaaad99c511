import re

from protocol.root import ROOT
from world.judge.verdict import Verdict

PAGE = ROOT / "docs" / "verdict.md"


def test_the_page_has_every_field_of_the_verdict_in_its_order() -> None:
    rows = [
        line.split("|")[1] for line in PAGE.read_text(encoding="utf-8").splitlines() if line.startswith("| `")
    ]
    assert [field for row in rows for field in re.findall(r"`(\w+)`", row)] == list(Verdict.__struct_fields__)
