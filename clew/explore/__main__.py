"""Explores the setting of a rule with the source of the working directory; prints one round a line.

`clew.explore.without` runs it as `python -m clew.explore RULE SECONDS` in a copy of the source.
"""

import sys
from collections.abc import Sequence

import msgspec

from clew.explore.explore import explore
from clew.explore.without import RULES


def main(arguments: Sequence[str]) -> int:
    """Explore; returns the exit code."""
    setting = RULES[arguments[0]].setting
    for each in explore(setting, setting.faults, float(arguments[1])):
        sys.stdout.buffer.write(msgspec.json.encode(each) + b"\n")
        sys.stdout.flush()
    return 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
