from pathlib import Path

import msgspec

from clew.manual.scenario import DOCUMENT, EXAMPLE, document
from world.scenario.scenario import load, schema


def test_the_page_is_what_the_types_say() -> None:
    assert DOCUMENT.read_text(encoding="utf-8") == document(), "run: python -m clew.manual.scenario"


def test_every_field_of_every_section_stands_in_the_page_and_says_what_it_means() -> None:
    for name, described in schema()["$defs"].items():
        for field in described.get("properties", {}):
            rows = [line for line in document().splitlines() if line.startswith(f"| `{field}` |")]
            # What the bounds are is said of their section; `shape` stands in the titles.
            meant = name == "Bounds" or field == "shape" or not any(row.endswith("|  |") for row in rows)
            assert meant, (name, field)
            assert rows or field == "shape", (name, field)


def test_every_field_says_its_default_or_that_it_is_required() -> None:
    page = document()
    assert "| `epsilon_m` | number, m | > 0, at most 10000 | required | least clearance" in page
    assert "| `range_sigma_m` | number, m | 0 to 1e+06 | `0.0` | " in page
    assert "| `goal` | Goal |  | none | " in page
    assert "| `law` | `certified` or `printed` or `resultant` |  | `certified` | " in page


def test_the_example_loads_and_stands_in_the_page(tmp_path: Path) -> None:
    path = tmp_path / "gate.toml"
    path.write_text(EXAMPLE, encoding="utf-8")
    assert load(str(path)).name == "gate"
    assert EXAMPLE in document()
    assert msgspec.toml.decode(EXAMPLE.encode()).keys() >= {"goal", "bounds", "obstacle"}


def test_a_queue_stands_as_the_page_says() -> None:
    poses = load("grove").fleet.poses()
    assert "`start = [1.5, 2.0, 0.0]` and `spacing_m = 0.3`, robot 2 stands at (1.2, 2.0)" in document()
    assert (poses[1].x_m, poses[1].y_m) == (1.2, 2.0)
