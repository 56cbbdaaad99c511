"""Writes `docs/scenario.md` from the types of a scenario: `python -m clew.manual.scenario`."""

from collections.abc import Mapping
from typing import Any

from clew.manual.tables import Schema, name_of, table
from protocol.root import ROOT
from world.scenario.scenario import schema

DOCUMENT = ROOT / "docs" / "scenario.md"

HEAD = """# A scenario file

All that a run is made of, in TOML. This page is made from the types in `world/scenario/scenario.py`,
`world/scenario/sections.py`, `world/geometry/shapes.py` and `world/geometry/moving.py` by
`python -m clew.manual.scenario`; a test keeps the
two the same. For editors there is the same as a JSON Schema, `launch/scenarios/scenario.schema.json` (begin
the file with `#:schema` and its path); `clew schema` prints it.

What cannot work is refused in one line, with exit code 2, before anything starts: the file, the field, what
it must be, and what the file says. A field that is not on this page is refused too. Places are in the world
frame, angles anti-clockwise from its x axis.
"""

RELATIONS = """## What has to fit together

- `speed_mps_min < speed_mps < speed_mps_max`, and `mu0_m < epsilon_m`.
- Places are at least `2 robot_radius_m + separation_m` apart; they, and the goal, are inside the bounds by
  the radius.
- The sensor is sure to see the thinnest obstacle from `2 (robot_radius_m + epsilon_m)` on; scans reach no
  further than it is sure of.
- Under `certified`, places are `robot_radius_m + epsilon_m` away from every obstacle (the goal at most its
  tolerance less), and `mu0_m` covers the error budget: ray quantisation + range noise + drive error, which a
  refusal names one by one. Most of what rays leave unseen the certificate keeps on top: up to the spacing of
  the rays at that range, more past sharp corners. Under the other laws it is enough not to touch.
- The times of a track increase, and no leg of it is faster than `obstacle_speed_mps_max`, nor than 100 m/s.
  No two moving obstacles have the same `id`, and none touches a robot at t = 0.
- `table_m` has a row for each of `switching_positions_max`, and a column for each obstacle.
"""

QUEUE = """## How a queue stands

`start` is the place of robot 1. The queue extends from there **against** the heading, one robot each
`spacing_m`: with `start = [1.5, 2.0, 0.0]` and `spacing_m = 0.3`, robot 2 stands at (1.2, 2.0) and robot 3 at
(0.9, 2.0). All face the same way. So there has to be room behind `start` for all `robots`, and for more if
`-n` asks for more. In a scene (JSON) the spacing is three radii. Numbers do not say who leads: robots line up
by where they stand.

## How robots are deployed at random

With `deployment = "random"`, or `--deployment random` for any scenario or scene, the seed draws the
places when the file is read, and writes them into the scenario as `places`: a run's timeline and its
checks know no others. They are free (`robot_radius_m + epsilon_m` from every obstacle, from those that
move where they first are), `2 robot_radius_m + separation_m + mu0_m` apart, inside the bounds, which
have to be said, and all on one piece of ground: that of the place that the file gives robot 1, `start`
say, or else of the goal. Of as many robots or more, the first start at the same places. A file that says
`deployment` and `places` is taken at its word, so the scenario of a timeline is the same again;
`--deployment random` draws anew.
"""

TRACKS = """## How an obstacle moves

It goes straight and evenly from one place of its track to the next, and does not turn. It stands at the first
place before the first time, and at the last after the last. Robots see it where it is when they take a scan;
beforehand they are told no more than `obstacle_speed_mps_max`. The promise is passive: no robot touches it
while the robot itself drives. It may drive into a robot that stands, and through it.
"""

EXAMPLE = """name = "gate"
description = "Three robots go between two posts"

[fleet]
robots = 3
robot_radius_m = 0.1
separation_m = 0.05
link_length_m_max = 1.0
start = [1.0, 1.0, 0.0]
spacing_m = 0.3

[law]
epsilon_m = 0.1
mu0_m = 0.01

[goal]
at_m = [4.0, 1.0]
tolerance_m = 0.1

[bounds]
x_m_min = 0.0
y_m_min = 0.0
x_m_max = 5.0
y_m_max = 2.0

[sensor]
directions = 1440
range_m_max = 4.0
range_sigma_m = 0.001

[drive]
speed_mps = 0.5
speed_mps_min = 0.05
speed_mps_max = 1.0
turn_rate_radps = 1.5
heading_error_rad = 0.0003

[time]
time_s_max = 100.0

[[obstacle]]
shape = "circle"
centre_m = [2.5, 1.6]
radius_m = 0.2

[[moving]]
id = "cart"
shape = "circle"
radius_m = 0.15
track = [[0.0, 3.2, 0.3], [6.0, 3.2, 1.7]]

[[obstacle]]
shape = "polygon"
vertices_m = [[2.3, 0.2], [2.7, 0.2], [2.7, 0.6], [2.3, 0.6]]
"""


def document() -> str:
    """The whole page."""
    components = schema()["$defs"]
    fields = {name: without_null(field) for name, field in components["Scenario"]["properties"].items()}
    top = f"## The file\n\n{_table(fields, components)}"
    sections = [
        _section(f"`[{name}]`", components[name_of(field)], components)
        for name, field in fields.items()
        if "$ref" in field
    ]
    shapes = [
        _section(f'`[[{key}]]`, `shape = "{name}"`', components[name_of({"$ref": reference})], components)
        for key in ("obstacle", "moving")
        for name, reference in fields[key]["items"]["discriminator"]["mapping"].items()
    ]
    example = f"## A complete example\n\n```toml\n{EXAMPLE}```\n"
    return "\n".join([HEAD, top, *sections, *shapes, RELATIONS, QUEUE, TRACKS, example])


def _section(title: str, described: Schema, components: Schema) -> str:
    fields = {name: without_null(field) for name, field in described["properties"].items() if name != "shape"}
    return f"## {title}\n\n{_paragraphs(described['description'])}\n\n{_table(fields, components)}"


def _table(fields: Mapping[str, Schema], components: Schema) -> str:
    defaults = {name: default(field) for name, field in fields.items()}
    return table(fields, components, {"default": defaults})


def without_null(field: Schema) -> dict[str, Any]:
    """A field without its null, which TOML cannot say: such a field may be left out."""
    if "anyOf" not in field:
        return dict(field)
    (kind,) = [choice for choice in field["anyOf"] if choice != {"type": "null"}]
    return {**kind, **{key: value for key, value in field.items() if key != "anyOf"}}


def default(field: Schema) -> str:
    """What holds where the file does not say a field."""
    if "default" not in field:
        return "required"
    value = field["default"]
    if isinstance(value, bool):
        return f"`{str(value).lower()}`"  # as TOML spells it
    return "none" if value in (None, "", ()) else f"`{value}`"


def _paragraphs(docstring: str) -> str:
    return "\n".join(line.strip() for line in docstring.splitlines())


if __name__ == "__main__":
    DOCUMENT.write_text(document(), encoding="utf-8")
