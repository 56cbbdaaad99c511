from typing import get_args

import msgspec
import pytest

from clew.manual.faults import DOCUMENT, document
from protocol.faults.plan import Plan, load
from protocol.faults.rules import Rule, StepPoint
from tests.support.faults import SHIPPED

PAGE = DOCUMENT.read_text(encoding="utf-8")


def test_the_page_is_what_the_types_say() -> None:
    assert document(PAGE) == PAGE, "run: python -m clew.manual.faults"


@pytest.mark.parametrize("kind", get_args(Rule), ids=lambda kind: str(kind.__name__))
def test_every_fault_and_every_field_of_it_stands_in_the_page_with_its_meaning(
    kind: type[msgspec.Struct],
) -> None:
    assert f"\n#### `{kind.__struct_config__.tag}`\n\n{kind.__doc__}\n" in PAGE
    for field in kind.__struct_encode_fields__:
        rows = [line for line in PAGE.splitlines() if line.startswith(f"| `{field}` |")]
        assert rows, field
        assert not any(row.endswith("|  |") for row in rows), field


def test_every_point_and_every_shipped_plan_stands_in_the_page() -> None:
    assert [point for point in StepPoint if f"\n| `{point}` | " not in PAGE] == []
    assert [name for name in SHIPPED if f"\n| `{name}` | {load(name).description} |" not in PAGE] == []


def test_the_example_is_a_plan() -> None:
    example = PAGE.split("```toml\n")[1].split("```")[0]
    plan = msgspec.toml.decode(example, type=Plan)
    assert [rule.name for rule in plan.rules] == ["drop-1", "kill-2"]
