"""Checks the house rules by reading the source: imports point down, clocks stay in shells."""

import ast
import importlib
import re
from collections.abc import Iterable, Iterator
from pathlib import Path

import pytest

from protocol.root import ROOT
from tests.house.parsed import parsed

PACKAGES = ("agents", "clew", "protocol", "world")

MAY_IMPORT = {
    "protocol": {"protocol"},
    "agents": {"agents", "protocol"},
    "world": {"world", "protocol"},
    "clew": set(PACKAGES),
}

OWNERS = ("agents/", "protocol/", "world/", "clew/coverage/", "clew/log/", "clew/rehearsal/")

ONLY_IN = {
    # The bare relays are the baseline of `clew bench hop`.
    "zenoh": {
        "clew/bench/hop/relay.py",
        "protocol/network/router.py",
        "protocol/network/zenoh_transport.py",
    },
    # The shells, the network ends that an event loop waits for, and pytest, which runs tests that are
    # coroutines. All other code gets the time as an argument.
    "asyncio": {
        "agents/process/host.py",
        "clew/bench/hop/__main__.py",
        "clew/bench/hop/relay.py",
        "clew/fleet/parts/processes.py",
        "clew/fleet/prepare.py",
        "clew/fleet/shell.py",
        "clew/fleet/table.py",
        "clew/log/follow.py",
        "clew/page/serve/channel.py",
        "clew/page/serve/server.py",
        "clew/pytest_plugin.py",
        "clew/verbs/log_cat.py",
        "clew/verbs/view.py",
        "protocol/__main__.py",
        "protocol/process/ending.py",
        "protocol/network/inbox.py",
        "protocol/network/zenoh_transport.py",
        "world/control.py",
        "world/shell.py",
    },
    "time": {
        "agents/process/shell.py",
        "clew/api/launched.py",
        "clew/bench/hop/__main__.py",
        "clew/bench/hop/relay.py",
        "clew/bench/live.py",
        "clew/campaign/episode.py",
        "clew/explore/explore.py",
        "clew/fleet/live.py",
        "clew/log/vigil.py",
        "clew/rehearsal/recorded.py",
        "clew/verbs/bench_forming.py",
        "clew/verbs/bench_plan.py",
        "clew/verbs/bench_rehearsal.py",
        "clew/verbs/bench_scale.py",
        "clew/verbs/bench_soak.py",
        "protocol/faults/manual_faults.py",
        "protocol/network/faulty_transport.py",
        "protocol/network/zenoh_transport.py",
        "world/life.py",
        "world/shell.py",
    },
    "datetime": {
        "clew/api/rehearsed.py",
        "clew/bench/machine.py",
        "clew/export/times.py",
        "clew/fleet/folder.py",
        "clew/fleet/prepare.py",
        "clew/rehearsal/recorded.py",
        "clew/verbs/campaign.py",
        "clew/verbs/chaos.py",
        "clew/verbs/ls.py",
        "clew/verbs/rehearse.py",
        "world/life.py",
        "world/shell.py",
    },
    "random": set[
        str
    ](),  # random draws come from `world.chance` and `protocol.faults.chance`, by seed and purpose
}

LINES_MAX = 400
FUNCTION_LINES_MAX = 70
IGNORE = re.compile(r"#\s*(?:noqa|type:\s*ignore)\S*(?:\s*[A-Z]+\d+(?:,\s*[A-Z]+\d+)*)?(?P<why>.*)")


def modules(root: Path) -> list[Path]:
    return [path for package in PACKAGES for path in sorted((root / package).rglob("*.py"))]


def complaints(root: Path, path: Path) -> Iterator[str]:
    """The violations of the house rules in a module."""
    text = path.read_text(encoding="utf-8")
    tree = parsed(text)
    nodes = list(ast.walk(tree))  # a walk takes longer than all that is looked for on it
    name = path.relative_to(root).as_posix()
    if not ast.get_docstring(tree):
        yield f"{name}: has no docstring"
    if (lines := len(text.splitlines())) > LINES_MAX:
        yield f"{name}: has {lines} lines, more than {LINES_MAX}"
    yield from import_complaints(name, nodes)
    for node in nodes:
        if isinstance(node, ast.FunctionDef | ast.AsyncFunctionDef) and node.end_lineno is not None:
            length = node.end_lineno - node.lineno + 1
            if length > FUNCTION_LINES_MAX:
                yield f"{name}: {node.name} has {length} lines, more than {FUNCTION_LINES_MAX}"
    yield from ownership_complaints(name, nodes)
    yield from ignore_complaints(name, text)


def import_complaints(name: str, nodes: Iterable[ast.AST]) -> Iterator[str]:
    allowed = MAY_IMPORT[name.partition("/")[0]]
    for module in imported(nodes):
        if module in PACKAGES and module not in allowed:
            yield f"{name}: imports {module}, which is not below it"
        if module in ONLY_IN and name not in ONLY_IN[module]:
            yield f"{name}: imports {module}, which only {sorted(ONLY_IN[module])} may"


def ownership_complaints(name: str, nodes: Iterable[ast.AST]) -> Iterator[str]:
    """Writes to attributes of anything but `self`: cores, shells and the rehearsal ask the owner instead."""
    if not name.startswith(OWNERS):
        return
    for place in written(nodes):
        target = place
        while isinstance(target, ast.Subscript):
            target = target.value
        if isinstance(target, ast.Attribute) and not is_self(target.value):
            yield f"{name}:{target.lineno}: writes another object's attribute, {ast.unparse(target)}"


def is_self(node: ast.expr) -> bool:
    return isinstance(node, ast.Name) and node.id == "self"


def written(nodes: Iterable[ast.AST]) -> Iterator[ast.expr]:
    """What is assigned to or deleted, anywhere in the file."""
    for node in nodes:
        context = getattr(node, "ctx", None)
        if isinstance(node, ast.expr) and isinstance(context, ast.Store | ast.Del):
            yield node


def imported(nodes: Iterable[ast.AST]) -> Iterator[str]:
    """The top-level names of all imports, anywhere in the file."""
    for node in nodes:
        if isinstance(node, ast.Import):
            yield from (alias.name.partition(".")[0] for alias in node.names)
        elif isinstance(node, ast.ImportFrom):
            yield node.module.partition(".")[0] if node.module and node.level == 0 else "a relative name"


def imported_by(path: Path) -> set[str]:
    return set(imported(ast.walk(parsed(path.read_text(encoding="utf-8"))))) if path.exists() else set()


def ignore_complaints(name: str, text: str) -> Iterator[str]:
    for number, line in enumerate(text.splitlines(), start=1):
        match = IGNORE.search(line)
        if match and len(re.findall(r"[A-Za-z]{2,}", match["why"])) < 2:
            yield f"{name}:{number}: ignores a check without saying why"


def test_modules_keep_the_house_rules() -> None:
    assert [said for path in modules(ROOT) for said in complaints(ROOT, path)] == []


def test_test_files_are_small_and_explain_their_ignores() -> None:
    texts = {
        path.relative_to(ROOT).as_posix(): path.read_text(encoding="utf-8")
        for path in sorted((ROOT / "tests").rglob("*.py"))
    }
    assert [name for name, text in texts.items() if len(text.splitlines()) > LINES_MAX] == []
    assert [said for name, text in texts.items() for said in ignore_complaints(name, text)] == []


@pytest.mark.parametrize(
    ("name", "source", "complaint"),
    [
        ("protocol/a.py", "from world.core import World", "imports world"),
        ("agents/a.py", "def f():\n    import world", "imports world"),
        ("world/a.py", "import agents.robot", "imports agents"),
        ("agents/a.py", "import zenoh", "imports zenoh"),
        ("world/a.py", "from time import monotonic", "imports time"),
        ("clew/a.py", "import random", "imports random"),
        ("clew/a.py", "x = 1\n" * 401, "has 402 lines"),
        ("clew/a.py", "def f():\n" + "    x = 1\n" * 70, "f has 71 lines"),
        ("agents/a.py", "def f(self, it):\n    it.x = 1", "another object's attribute, it.x"),
        ("world/a.py", "def f(self):\n    self._a.x += 1", "another object's attribute, self._a.x"),
        ("world/a.py", "def f(self, it):\n    it.rows[1] = 2", "another object's attribute, it.rows"),
        ("protocol/a.py", "def f(it):\n    a, it.x = 1, 2", "another object's attribute, it.x"),
        ("clew/rehearsal/a.py", "def f(it):\n    del it.x", "another object's attribute, it.x"),
        ("clew/a.py", "x = 1  # no" + "qa: E501", "without saying why"),
        ("clew/a.py", "x = 1  # type" + ": ignore[misc]", "without saying why"),
    ],
)
def test_planted_violation_is_found(tmp_path: Path, name: str, source: str, complaint: str) -> None:
    path = tmp_path / name
    path.parent.mkdir(parents=True)
    path.write_text('"""Planted."""\n' + source, encoding="utf-8")
    found = list(complaints(tmp_path, path))
    assert [text for text in found if complaint in text] == found
    assert found


def test_module_without_docstring_is_found(tmp_path: Path) -> None:
    path = tmp_path / "clew" / "a.py"
    path.parent.mkdir(parents=True)
    path.write_text("x = 1\n", encoding="utf-8")
    assert list(complaints(tmp_path, path)) == ["clew/a.py: has no docstring"]


def test_explained_ignore_passes() -> None:
    assert list(ignore_complaints("a.py", "x = 1  # no" + "qa: S603  the program is our own")) == []


@pytest.mark.parametrize("package", PACKAGES)
def test_our_names_resolve_inside_this_tree(package: str) -> None:
    found = importlib.import_module(package).__file__
    assert found is not None
    assert Path(found).is_relative_to(ROOT)


@pytest.mark.parametrize("module", ONLY_IN)
def test_every_file_that_may_import_a_clock_or_zenoh_does(module: str) -> None:
    idle = [name for name in sorted(ONLY_IN[module]) if module not in imported_by(ROOT / name)]
    assert idle == []


def test_launch_holds_one_set_up_script_and_no_python_package() -> None:
    # ROS 2 owns the package name `launch`. The script runs before an environment exists, outside any package.
    assert list((ROOT / "launch").rglob("*.py")) == [ROOT / "launch" / "locked.py"]
