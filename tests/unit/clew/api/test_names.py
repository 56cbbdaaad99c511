"""The public names: there, few, loaded late, and explained by examples that are true."""

import ast
import doctest
import pkgutil
from importlib import import_module
from pathlib import Path

import pytest

import clew
from protocol import laws
from protocol.root import ROOT
from tests.support.docs import example
from tests.support.notebook import played
from tests.support.processes.loading import loaded

FLAGS = doctest.ELLIPSIS
NAMES_MAX = 24  # about a dozen, and a name for each fault
SLOW = {"numpy", "scipy", "msgspec", "zenoh", "matplotlib", "pandas", "click"}


def test_every_name_is_there_and_none_hides_a_package_of_ours() -> None:
    assert len(clew.__all__) <= NAMES_MAX
    assert all(hasattr(clew, name) for name in clew.__all__)
    assert dir(clew) == sorted(clew.__all__)
    assert {each.name for each in pkgutil.iter_modules(clew.__path__)} & set(clew.__all__) == set()


def test_type_checkers_and_programs_see_the_same_names() -> None:
    tree = ast.parse((ROOT / "clew" / "__init__.py").read_text(encoding="utf-8"))
    imports = [node for node in ast.walk(tree) if isinstance(node, ast.ImportFrom) and node.module]
    seen = {
        alias.asname or alias.name: (node.module, alias.name)
        for node in imports
        for alias in node.names
        if node.module != "importlib"
    }
    assert sorted(seen) == sorted(clew.__all__)
    for name, (module, kept) in seen.items():
        assert getattr(clew, name) is getattr(import_module(str(module)), kept)


def test_an_unknown_name_is_refused() -> None:
    with pytest.raises(AttributeError, match="module 'clew' has no attribute 'rehears'"):
        _ = getattr(clew, "rehears")  # noqa: B009 - a type checker refuses the plain attribute


def test_importing_clew_or_its_plugin_loads_nothing_slow() -> None:
    assert loaded("import clew") & SLOW == set()
    assert loaded("import clew.pytest_plugin") & SLOW == set()


def test_only_a_launch_needs_zenoh(tmp_path: Path) -> None:
    script = (
        f"import clew\nrun = clew.rehearse('grove', robots=1, out={str(tmp_path / 'run')!r})\nrun.check()"
    )
    assert "zenoh" not in loaded(script)


@pytest.mark.parametrize("module", ["clew", "faults", "rehearsed", "launched", "run"])
def test_the_examples_in_docstrings_are_true(
    module: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    tested = clew if module == "clew" else import_module(f"clew.api.{module}")
    found = doctest.testmod(tested, extraglobs={"clew": clew}, optionflags=FLAGS)
    assert found.failed == 0
    assert found.attempted > 0 or module == "run"


@pytest.mark.parametrize(("page", "least"), [("python.md", 16), ("laws.md", 7), ("fields.md", 8)])
def test_the_examples_of_the_pages_are_true(
    page: str, least: int, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr(laws, "_registered", {})  # the laws of the page are for this test alone
    found = doctest.testfile(str(ROOT / "docs" / page), module_relative=False, optionflags=FLAGS)
    assert (found.failed, found.attempted >= least) == (0, True)


def test_the_plot_of_the_page_is_drawn(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    pytest.importorskip("pandas")
    monkeypatch.chdir(tmp_path)
    clew.rehearse("grove", robots=2)
    [shown] = played(iter([example("python.md", "py")]))
    assert "image/png" in shown[-1]["data"]


def test_the_page_names_every_function_and_every_part_of_a_run_and_a_fleet() -> None:
    text = (ROOT / "docs" / "python.md").read_text(encoding="utf-8")
    of_run = [name for name in vars(clew.Run) if not name.startswith("_")]
    of_fleet = [name for name in vars(clew.Fleet) if not name.startswith("_")]
    unsaid = {"Entry", "Fleet", "Law", "Run", "Seen", "Step"} | {
        "begin",
        "close",
        "is_over",
        "lines",
        "now_s",
        "given_count",
        "asked",
    }
    unsaid |= {"last_s", "sentences", "has_begun", "end"}
    names = {*clew.__all__, *of_run, *of_fleet} - unsaid
    assert sorted(name for name in names if f"`{name}" not in text and f".{name}" not in text) == []
