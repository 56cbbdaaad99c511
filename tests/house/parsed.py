"""Our own source files, parsed, for the tests that read all of them. Not a test file."""

import ast
from functools import cache


@cache
def parsed(text: str) -> ast.Module:
    """The same tree for the same text: several tests read all our files."""
    return ast.parse(text)
