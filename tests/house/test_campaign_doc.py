import re

from clew.campaign.campaign import Campaign
from clew.campaign.classes import ClassFigures
from clew.campaign.episode import Outcome, Surprise
from clew.campaign.families import Figures
from protocol.root import ROOT

SECTIONS = (ROOT / "docs" / "campaign.md").read_text(encoding="utf-8").split("\n## ")


def named(section: str) -> set[str]:
    """What the first column of a section's tables names."""
    (text,) = [each for each in SECTIONS if each.startswith(section)]
    rows = re.findall(r"^\| (`.*?) \|", text, re.MULTILINE)
    return {name for row in rows for name in re.findall(r"`(\w+)`", row)}


def test_every_field_of_an_outcome_and_every_surprise_is_explained_and_no_other() -> None:
    surprises = {surprise.value for surprise in Surprise} - {"none"}
    assert named("An outcome") == set(Outcome.__struct_fields__) | surprises


def test_every_field_of_a_campaign_is_explained_and_no_other() -> None:
    assert named("`campaign.json`") == set(Campaign.__struct_fields__)


def test_every_figure_is_explained_and_no_other() -> None:
    assert named("The figures\n") == set(Figures.__struct_fields__)


def test_every_figure_of_a_class_is_explained_and_no_other() -> None:
    assert named("The figures by class") == set(ClassFigures.__struct_fields__)
