"""The long form: `python -m tests.model` prints what breaks without which rules, and what stays clean."""

import argparse
import sys

from tests.model.rules import DESIGN, Rule
from tests.model.search import Ended, Found, search
from tests.model.searches import BROKEN, LONG, NOT_SHOWN, SHORT, Clean, Without
from tests.model.setting import Setting


def say(*lines: str) -> None:
    """Print at once: a search may take minutes."""
    sys.stdout.write("".join(f"{line}\n" for line in lines))
    sys.stdout.flush()


def row(name: str, broken: str, found: Found) -> str:
    """A line of either table."""
    return f"| {name} | {broken} | {found.depth} | {found.states:,} | {found.ended} | {found.cpu_s:.1f} |"


def names(rules: frozenset[Rule]) -> str:
    """Rules, in the order of `rules.py`."""
    return ", ".join(f"{rule.name} ({rule.family})" for rule in Rule if rule in rules)


def say_broken(entry: Without, seconds: float, *, traced: bool) -> bool:
    """Search without some rules; is what breaks what the table says?"""
    found = search(Setting(DESIGN - entry.rules, entry.bounds, {entry.broken}), seconds)
    say(row(names(entry.rules), found.broken or "nothing", found))
    if traced:
        say(*(f"    {happened}" for happened in found.trace))
    return (found.broken, found.depth) == (entry.broken, entry.depth)


def say_clean(entry: Clean, seconds: float) -> bool:
    """Search with all rules; is it clean, and as large as the table says?"""
    found = search(Setting(DESIGN, entry.bounds), seconds)
    say(row(entry.name, found.broken or "nothing", found), *(f"    {happened}" for happened in found.trace))
    closed_otherwise = found.ended is Ended.CLOSED and entry.states not in {0, found.states}
    return found.broken is None and not closed_otherwise


def main() -> int:
    """Print both tables; 1 where they differ from `searches.py`."""
    parser = argparse.ArgumentParser(prog="python -m tests.model", description=__doc__)
    parser.add_argument("--seconds", type=float, default=60.0, help="CPU seconds for each search (60)")
    parser.add_argument("--trace", action="store_true", help="print the shortest trace of each breach")
    asked = parser.parse_args()
    head = ("| property broken | depth | states | ended | CPU s |", "|---|---|---|---|---|---|")
    say("| without " + head[0], head[1])
    as_said = [say_broken(entry, asked.seconds, traced=asked.trace) for entry in BROKEN]
    say("", *(f"{rule.name} is not shown: {why}" for rule, why in NOT_SHOWN.items()))
    say("", "| all rules " + head[0], head[1])
    as_said += [say_clean(entry, asked.seconds) for entry in (*SHORT, *LONG)]
    return 0 if all(as_said) else 1


if __name__ == "__main__":
    sys.exit(main())
