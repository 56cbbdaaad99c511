"""The docs match the types, in generated parts and in tables written by hand."""

import re
from typing import get_args

import msgspec
import pytest

from clew.campaign.campaign import Campaign
from clew.campaign.chaos import Chaos, ChaosRun
from clew.campaign.classes import ClassFigures
from clew.campaign.episode import Outcome, Surprise
from clew.campaign.families import Figures
from clew.manual.parts import PARTS, SCHEMAS, Part, schema_line, with_part
from protocol.faults.plan import Plan, load
from protocol.faults.rules import Rule, StepPoint
from protocol.timeline import Record
from protocol.timeline.invariants import NAMES
from tests.support.campaigns import clew
from tests.support.docs import example, explained, page
from tests.support.faults import SHIPPED
from world.judge.verdict import Verdict
from world.scenario.scenario import load as load_scenario
from world.scenario.scenario import schema

SURPRISES = tuple(surprise.value for surprise in Surprise if surprise is not Surprise.NONE)
SECTION = "\n## "
BY_HAND = {
    "an outcome": ("campaign.md", "\n## An outcome", SECTION, (*Outcome.__struct_fields__, *SURPRISES)),
    "a campaign": ("campaign.md", "\n## `campaign.json`", SECTION, Campaign.__struct_fields__),
    "figures": ("campaign.md", "\n## The figures\n", SECTION, Figures.__struct_fields__),
    "figures of a class": (
        "campaign.md",
        "\n## The figures by class",
        SECTION,
        ClassFigures.__struct_fields__,
    ),
    "chaos": ("chaos.md", "\n| field of `chaos.json` | meaning |\n", "\n\n", Chaos.__struct_fields__),
    "a run of chaos": ("chaos.md", "\n| field of a run | meaning |\n", "\n\n", ChaosRun.__struct_fields__),
    "a verdict": ("verdict.md", "\n| field | meaning |\n", "\n\n", Verdict.__struct_fields__),
}


@pytest.mark.parametrize("part", PARTS, ids=lambda part: str(part.file))
def test_every_generated_part_matches_its_source(part: Part) -> None:
    assert part.path.read_text(encoding="utf-8") == part.current(), "run: python -m clew.manual"


def test_no_description_in_a_schema_has_a_second_line() -> None:
    """Python 3.13 takes the indentation off docstrings: what is generated would depend on the version."""
    texts = [part.current() for part in PARTS if part.file.endswith(".json")]
    assert texts
    assert not [text for text in texts if "\\n" in text]


@pytest.mark.parametrize(("name", "begins", "ends", "fields"), BY_HAND.values(), ids=BY_HAND)
def test_every_table_written_by_hand_explains_exactly_the_fields_of_its_type(
    name: str, begins: str, ends: str, fields: tuple[str, ...]
) -> None:
    assert sorted(set(explained(name, begins, ends))) == sorted(fields)


@pytest.mark.parametrize("what", SCHEMAS)
def test_the_verb_prints_the_schema_on_one_line(what: str) -> None:
    assert clew("schema", what).stdout == schema_line(what)
    assert schema_line(what).count("\n") == 1


def test_writing_keeps_the_text_around_the_marks_and_is_idempotent() -> None:
    marked = "before\n<!-- begin a: made -->\nold\n<!-- end a -->\nafter\n"
    once = with_part(marked, "a", "new\n")
    assert once == "before\n<!-- begin a: made -->\n\nnew\n\n<!-- end a -->\nafter\n"
    assert with_part(once, "a", "new\n") == once
    with pytest.raises(AssertionError, match="stand 0 times"):
        with_part(marked, "b", "new\n")


@pytest.mark.parametrize("kind", get_args(Rule), ids=lambda kind: str(kind.__name__))
def test_every_fault_and_every_field_of_it_has_a_meaning(kind: type[msgspec.Struct]) -> None:
    text = page("faults.md")
    assert f"\n#### `{kind.__struct_config__.tag}`\n\n{kind.__doc__}\n" in text
    for field in kind.__struct_encode_fields__:
        rows = [line for line in text.splitlines() if line.startswith(f"| `{field}` |")]
        assert rows, field
        assert not any(row.endswith("|  |") for row in rows), field


def test_the_page_names_every_step_point_and_every_shipped_plan() -> None:
    text = page("faults.md")
    assert [point for point in StepPoint if f"\n| `{point}` | " not in text] == []
    assert [name for name in SHIPPED if f"\n| `{name}` | {load(name).description} |" not in text] == []


def test_every_field_of_a_scenario_has_a_meaning() -> None:
    lines = page("scenario.md").splitlines()
    for name, described in schema()["$defs"].items():
        for field in described.get("properties", {}):
            rows = [line for line in lines if line.startswith(f"| `{field}` |")]
            # The section on bounds explains those; `shape` is in the titles.
            assert name == "Bounds" or field == "shape" or not any(row.endswith("|  |") for row in rows)
            assert rows or field == "shape", (name, field)


def test_every_field_has_its_default_or_is_marked_as_required() -> None:
    text = page("scenario.md")
    assert "| `epsilon_m` | number, m | > 0, at most 10000 | required | least clearance" in text
    assert "| `range_sigma_m` | number, m | 0 to 1e+06 | `0.0` | " in text
    assert "| `goal` | Goal |  | none | " in text
    assert "[.]py:[A-Za-z0-9_@]+)$` | `certified` | the rule that makes a switching step" in text


def test_the_page_names_every_kind_of_entry_and_every_field() -> None:
    for kind in get_args(Record):
        section = page("timeline.md").split(f"### `{kind.__struct_config__.tag}`\n")[1].split("###")[0]
        assert [field for field in kind.__struct_fields__ if f"| `{field}` |" not in section] == []


def test_the_examples_load() -> None:
    plan = msgspec.toml.decode(example("faults.md"), type=Plan)
    assert [rule.name for rule in plan.rules] == ["drop-1", "kill-2"]
    said = msgspec.toml.decode(example("scenario.md"))
    assert {"goal", "bounds", "obstacle"} <= said.keys()
    assert msgspec.convert(said, type(load_scenario("grove"))).name == "gate"


def test_a_queue_is_placed_as_the_page_says() -> None:
    poses = load_scenario("grove").fleet.poses()
    assert "`start = [1.5, 2.0, 0.0]` and\n`spacing_m = 0.3`, robot 2 stands at (1.2, 2.0)" in page(
        "scenario.md"
    )
    assert (poses[1].x_m, poses[1].y_m) == (1.2, 2.0)


def test_the_page_of_the_verdict_names_each_invariant_as_it_is_printed() -> None:
    rows = re.findall(r"^\| ([A-Z]\d) \| ([^:]+): ", page("verdict.md"), re.MULTILINE)
    assert rows == list(NAMES.items())
