"""Rehearses 50 cases on two checkouts and compares their timelines byte for byte. Not a test file.

    python -m tests.support.same_bytes BEFORE AFTER

BEFORE and AFTER are checkouts, for example two git worktrees. A change that means to change no behaviour
leaves all timelines the same. For each case that differs it prints the first line of the timeline that does,
and it exits with 1 if there is one. The cases: each scenario with two seeds, `grove` under each shipped fault
plan, and the first of tests/rehearsals/drawn. Both play the files of this checkout: descriptions stand in
the timeline, too.
"""

import os
import subprocess
import sys
import tempfile
from collections.abc import Iterator, Sequence
from concurrent.futures import ThreadPoolExecutor
from itertools import zip_longest
from pathlib import Path

from protocol.root import ROOT

CASES = 50
DRAWN = ROOT / "tests" / "rehearsals" / "drawn"
Case = Sequence[str]


def cases() -> list[Case]:
    """The arguments of `clew rehearse` for each case."""
    scenarios = sorted(map(str, (ROOT / "launch" / "scenarios").glob("*.toml")))
    plans = sorted(map(str, (ROOT / "launch" / "faults").glob("*.toml")))
    grove = str(ROOT / "launch" / "scenarios" / "grove.toml")
    drawn = sorted(DRAWN.glob("*.faults.toml"))
    all_cases: list[Case] = [(name, "--seed", seed) for name in scenarios for seed in ("1", "2")]
    all_cases += [(grove, "--seed", "3", "--faults", name) for name in plans]
    all_cases += [(str(path).replace(".faults", ""), "--seed", "1", "--faults", str(path)) for path in drawn]
    return all_cases[:CASES]


def rehearsed(checkout: Path, case: Case) -> list[bytes]:
    """The lines of the case's timeline, or the last line of stderr where there is none."""
    package = "clew" if (checkout / "clew").is_dir() else "lab"
    with tempfile.TemporaryDirectory() as folder:
        run = Path(folder) / "run"
        ended = subprocess.run(
            [sys.executable, "-m", f"{package}.cli", "rehearse", *case, "--out", run],
            cwd=checkout,
            env={**os.environ, "PYTHONPATH": str(checkout), "PYTHONSAFEPATH": "1"},
            capture_output=True,
            check=False,
        )
        events = run / "events.jsonl"
        return events.read_bytes().splitlines() if events.exists() else ended.stderr.splitlines()[-1:]


def differences(before: Path, after: Path, case: Case) -> Iterator[str]:
    """The first line in which the two timelines differ, if any."""
    sides = (rehearsed(before, case), rehearsed(after, case))
    for number, (one, other) in enumerate(zip_longest(*sides, fillvalue=b"(no line)"), start=1):
        if one != other:
            yield f"line {number}:\n  before: {one[:300]!r}\n  after:  {other[:300]!r}"
            return


def main(before: str, after: str) -> int:
    """Compare all cases; returns the exit code."""
    different = 0
    with ThreadPoolExecutor(os.cpu_count()) as pool:
        found = pool.map(lambda case: list(differences(Path(before), Path(after), case)), cases())
        for case, said in zip(cases(), found, strict=True):
            different += bool(said)
            print(" ".join(case), *said or ("the same",))  # noqa: T201 - a person reads it
    print(f"{len(cases()) - different} of {len(cases())} the same")  # noqa: T201 - a person reads it
    return min(different, 1)


if __name__ == "__main__":
    sys.exit(main(*sys.argv[1:]))
