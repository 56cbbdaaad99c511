"""Which parts of the docs, and which schemas, are generated, and from what.

Rule 1: a generated part stands between two marks with its name. The text around the marks is written by hand.
Rule 2: a schema for editors is a whole file of one line.
"""

import json
import re
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

from clew.explore.without import RULES
from clew.manual.faults import rules
from clew.manual.scenario import sections
from clew.manual.timeline import kinds
from clew.mutants.list import MUTANTS
from clew.mutants.mutant import Mutant
from protocol.faults import plan
from protocol.root import ROOT
from world.scenario import scenario

SCHEMAS = {"scenario": scenario.schema, "faults": plan.schema}


@dataclass(frozen=True, slots=True)
class Part:
    """A part of a file of ours, or the whole file."""

    file: str
    name: str | None
    """As the marks have it; None: the part is the whole file."""
    make: Callable[[], str]

    @property
    def path(self) -> Path:
        """Where the file is."""
        return ROOT / self.file

    def current(self) -> str:
        """The file as it should be now."""
        made = self.make()
        return (
            made if self.name is None else with_part(self.path.read_text(encoding="utf-8"), self.name, made)
        )


def with_part(page: str, name: str, text: str) -> str:
    """The page with this text between the marks of this name; both marks must be there."""
    marks = re.compile(rf"(<!-- begin {name}\b[^\n]*-->\n).*?(<!-- end {name} -->\n)", re.DOTALL)
    changed, count = marks.subn(lambda found: f"{found[1]}\n{text.rstrip()}\n\n{found[2]}", page)
    assert count == 1, f"the marks of {name} stand {count} times in the page, not once"
    return changed


def schema_line(of: str) -> str:
    """The JSON Schema of a scenario file or of a fault plan, on one line."""
    return json.dumps(SCHEMAS[of]()) + "\n"


def mutants() -> str:
    """Each mutant, the rule that it breaks, and what catches it."""
    rows = [f"| `{each.name}` | {each.rule} | {_catcher(each)} |" for each in MUTANTS]
    return "\n".join(["| mutant | the rule that it breaks | caught by |", "|---|---|---|", *rows])


def _catcher(mutant: Mutant) -> str:
    if mutant.check:
        return f"`{mutant.check}`"
    rule = next((rule for rule, each in RULES.items() if each.mutant == mutant), None)
    swarm = f"a swarm, by {' or '.join(mutant.breaks)}"
    return swarm if rule is None else f"{swarm}; `explore --without {rule}`"


PARTS = (
    Part("docs/scenario.md", "sections", sections),
    Part("docs/faults.md", "rules", rules),
    Part("docs/timeline.md", "kinds", kinds),
    Part("docs/mutants.md", "mutants", mutants),
    Part("launch/scenarios/scenario.schema.json", None, lambda: schema_line("scenario")),
    Part("launch/faults/plan.schema.json", None, lambda: schema_line("faults")),
)
