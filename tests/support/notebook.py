"""Runs the notebook of the docs: `python -m tests.support.notebook` runs it again and keeps what it shows.

A kernel of Jupyter brings 37 packages. The cells need none of them: they are Python, one after the other in
one namespace, and the value of a cell's last expression is shown.
"""

import ast
import base64
import os
import tempfile
from collections.abc import Iterator
from contextlib import redirect_stdout
from io import BytesIO, StringIO
from pathlib import Path
from typing import Any

import matplotlib as mpl
import msgspec
from matplotlib import pyplot as plt

from protocol.root import ROOT

NOTEBOOK = ROOT / "docs" / "notebook.ipynb"
PNG_DPI = 110

Shown = dict[str, Any]


def cells(path: Path = NOTEBOOK) -> list[dict[str, Any]]:
    """The cells of a notebook."""
    found: list[dict[str, Any]] = msgspec.json.decode(path.read_bytes())["cells"]
    return found


def played(sources: Iterator[str]) -> Iterator[list[Shown]]:
    """What each cell shows, as a notebook keeps it."""
    mpl.use("agg")
    namespace: dict[str, Any] = {}
    for source in sources:
        printed = StringIO()
        with redirect_stdout(printed):
            value = _run(source, namespace)
        yield [*_text(printed.getvalue()), *_value(value), *_figures()]


def _run(source: str, namespace: dict[str, Any]) -> Any:  # noqa: ANN401 - of any expression
    """Run a cell; returns the value of its last line, if that is an expression."""
    body = ast.parse(source).body
    last = body.pop() if isinstance(body[-1], ast.Expr) else None
    exec(compile(ast.Module(body, []), "notebook", "exec"), namespace)
    if not isinstance(last, ast.Expr):
        return None
    return eval(compile(ast.Expression(last.value), "notebook", "eval"), namespace)


def _text(printed: str) -> Iterator[Shown]:
    if printed:
        yield {"output_type": "stream", "name": "stdout", "text": printed.splitlines(keepends=True)}


def _value(value: Any) -> Iterator[Shown]:  # noqa: ANN401 - of any expression
    if value is None:
        return
    data = {"text/plain": [repr(value)]}
    if hasattr(value, "_repr_html_"):
        data["text/html"] = value._repr_html_().splitlines(keepends=True)
    yield {"output_type": "execute_result", "data": data, "metadata": {}, "execution_count": None}


def _figures() -> Iterator[Shown]:
    for number in plt.get_fignums():
        with BytesIO() as file:
            plt.figure(number).savefig(file, format="png", dpi=PNG_DPI, bbox_inches="tight")
            png = base64.b64encode(file.getvalue()).decode()
        yield {"output_type": "display_data", "data": {"image/png": png}, "metadata": {}}
    plt.close("all")


def main() -> None:
    """Run the notebook and keep what it shows."""
    book = msgspec.json.decode(NOTEBOOK.read_bytes())
    code = [cell for cell in book["cells"] if cell["cell_type"] == "code"]
    with tempfile.TemporaryDirectory() as folder:
        os.chdir(folder)
        shown = list(played("".join(cell["source"]) for cell in code))
    for number, (cell, outputs) in enumerate(zip(code, shown, strict=True), start=1):
        for output in outputs:
            if "execution_count" in output:
                output["execution_count"] = number
        cell["execution_count"], cell["outputs"] = number, outputs
    NOTEBOOK.write_bytes(msgspec.json.format(msgspec.json.encode(book), indent=1) + b"\n")


if __name__ == "__main__":
    main()
