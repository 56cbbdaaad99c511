import re
from pathlib import Path

import pytest

from clew.campaign.mutants import hunt, plant
from clew.campaign.mutants_list import BUGS, Bug, Edit
from protocol.errors import UsageError
from protocol.root import ROOT


@pytest.mark.parametrize("bug", BUGS, ids=lambda bug: bug.name)
def test_every_bug_finds_the_source_that_it_breaks_and_what_it_leaves_is_source(bug: Bug) -> None:
    for edit in bug.edits:
        text = (ROOT / edit.file).read_text(encoding="utf-8")
        assert text.count(edit.before) == 1
        compile(text.replace(edit.before, edit.after), edit.file, "exec")


def test_there_are_fifteen_bugs_at_least_each_with_a_name_of_its_own() -> None:
    names = [bug.name for bug in BUGS]
    assert len(set(names)) == len(names) >= 15


def test_every_bug_stands_in_the_documentation_with_its_rule() -> None:
    text = (ROOT / "docs" / "mutants.md").read_text(encoding="utf-8")
    rows = re.findall(r"^\| `([a-z-]+)` \| (.*) \|$", text, re.MULTILINE)
    assert rows == [(bug.name, bug.rule) for bug in BUGS]


def test_a_bug_whose_source_is_not_there_any_more_is_an_error(tmp_path: Path) -> None:
    gone = Bug("gone", "", (Edit("protocol/wire/link.py", "this was never written", ""),))
    with pytest.raises(UsageError, match="0 times, not once"):
        plant(gone, tmp_path)


def test_a_planted_bug_is_caught_and_what_is_no_bug_is_not() -> None:
    bugs = {bug.name: bug for bug in BUGS}
    caught = hunt(bugs["no-separation"])
    assert caught.ok
    assert "S2" in str(caught.by)
    harmless = Bug(
        "harmless", "", (Edit("protocol/wire/link.py", "class Link(", "class Link("),), seeds_max=1
    )
    assert not hunt(harmless).ok
