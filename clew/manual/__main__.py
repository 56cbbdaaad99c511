"""Writes all generated parts of the docs, and the schemas: `python -m clew.manual`."""

import sys

from clew.manual.parts import PARTS

if __name__ == "__main__":
    for part in PARTS:
        current = part.current()
        if part.path.read_text(encoding="utf-8") != current:
            part.path.write_text(current, encoding="utf-8")
            sys.stdout.write(f"{part.file}\n")
