"""Rooms: each has one subject and a floor, imports point down, and no folder holds too many files."""

import ast
import re
import sys
from collections import Counter
from collections.abc import Iterator, Sequence
from graphlib import CycleError, TopologicalSorter
from pathlib import Path

import pytest

from protocol.root import ROOT
from tests.house.parsed import parsed

FLOORS: dict[str, dict[str, int]] = {
    # Rooms end with a slash; files beside the rooms are named one by one. On the same floor, files beside the
    # rooms may import each other; rooms may not.
    "protocol": {
        **dict.fromkeys(("arrays", "errors", "exit_codes", "frames", "keys", "plain", "root"), 0),
        **dict.fromkeys(("fence", "mission", "path", "sweep", "files/", "process/"), 1),
        **dict.fromkeys(("law_files", "laws"), 2),
        "timeline/": 2,
        "faults/": 3,
        "run_settings": 4,
        "wire/": 4,
        **dict.fromkeys(("legs", "network/"), 5),
        "__main__": 6,
        "__init__": 7,
    },
    "agents": {
        **dict.fromkeys(("commands", "due", "events", "navigation/"), 0),
        "body/": 1,
        "liveness/": 2,
        "strand/": 3,
        "coordinating/": 4,
        "membership/": 5,
        "robot": 6,
        "process/": 7,
        "__main__": 8,
        "__init__": 9,
    },
    "world": {
        **dict.fromkeys(("answers", "attendance", "chance", "commands", "events", "faults"), 0),
        **dict.fromkeys(("quota", "routing"), 0),
        "geometry/": 0,
        "scenario/": 1,
        "judge/": 2,
        "record/": 3,
        **dict.fromkeys(("bodies/", "control"), 4),
        "core": 5,
        **dict.fromkeys(("closing", "pace"), 6),
        "life": 7,
        "shell": 8,
        "__main__": 9,
        "__init__": 10,
    },
    "clew": {
        "percentiles": 0,
        "judge/": 0,
        **dict.fromkeys(("fields/", "log/", "maps/", "rehearsal/"), 1),
        **dict.fromkeys(("coverage/", "story/", "swarm/"), 2),
        **dict.fromkeys(("export/", "fleet/", "page/"), 3),
        **dict.fromkeys(("campaign/", "page/serve/"), 4),
        **dict.fromkeys(("figures/", "mutants/"), 5),
        **dict.fromkeys(("api/", "bench/", "explore/"), 6),
        "manual/": 7,
        "verbs/": 8,
        **dict.fromkeys(("__init__", "cli", "pytest_plugin"), 9),
    },
}

FILES_MAX = 16
MAY_HOLD_MORE = ("clew/verbs", "tests/unit/")
SOURCES = {".py", ".js", ".css"}
MAY_BORROW = re.compile(r"^\s*(?:from|import)\s(?:[^\n(]|\([^)]*)*\btest_", re.MULTILINE)
"""An import with the name of a test file in it: parsing all tests for the few that have one takes seconds."""


def room_of(name: str) -> str:
    """The room of a file, or the file's own name if it is beside the rooms of its package."""
    package, *folders = name.split("/")
    if len(folders) == 1:
        return folders[0].removesuffix(".py")
    above = ["/".join(folders[:end]) + "/" for end in range(len(folders) - 1, 0, -1)]
    return next((room for room in above if room in FLOORS[package]), above[-1])


def sources(root: Path, *packages: str) -> dict[str, ast.Module]:
    """All our files, parsed, by their names below the root."""
    return {
        path.relative_to(root).as_posix(): parsed(path.read_text(encoding="utf-8"))
        for package in packages
        for path in sorted((root / package).rglob("*.py"))
    }


def module_of(name: str) -> str:
    return name.removesuffix(".py").removesuffix("/__init__").replace("/", ".")


def statements(body: Sequence[ast.AST]) -> Iterator[ast.AST]:
    """All statements, at any depth: a walk through their expressions as well takes five times as long."""
    for each in body:
        yield each
        for within in ("body", "orelse", "finalbody", "handlers", "cases"):
            yield from statements(getattr(each, within, ()))


def imports_of(name: str, tree: ast.Module, files: dict[str, str]) -> Iterator[str]:
    """Our files that a file imports; `files` maps modules to files."""
    for node in statements(tree.body):
        if isinstance(node, ast.Import):
            yield from (files[alias.name] for alias in node.names if alias.name in files)
        elif isinstance(node, ast.ImportFrom):
            said = (f"{node.module}.{alias.name}" for alias in node.names)
            found = {files.get(each, files.get(node.module or "", name)) for each in said}
            yield from sorted(found - {name})


def arrows(trees: dict[str, ast.Module]) -> dict[str, list[str]]:
    """The imports of each file, among the given files."""
    files = {module_of(name): name for name in trees}
    return {name: list(imports_of(name, tree, files)) for name, tree in trees.items()}


def floor_complaints(root: Path) -> Iterator[str]:
    """Imports between the rooms of a package that do not point down."""
    for package, floors in FLOORS.items():
        for name, wanted in arrows(sources(root, package)).items():
            here = room_of(name)
            if here not in floors:
                yield f"{name}: {here} has no floor"
                continue
            for other in wanted:
                there = room_of(other)
                if there == here or there not in floors:
                    continue
                beside = not here.endswith("/") and not there.endswith("/")
                if floors[there] > floors[here] or (floors[there] == floors[here] and not beside):
                    yield f"{name}: imports {other}, which is not below it"


def cycle_complaints(root: Path) -> Iterator[str]:
    """Files that import each other, directly or through others."""
    try:
        TopologicalSorter(arrows(sources(root, *FLOORS))).prepare()
    except CycleError as error:
        yield " imports ".join(reversed(error.args[1]))


def idle_floors(root: Path) -> set[str]:
    """Rooms in the table that do not exist."""
    found = {f"{name.partition('/')[0]}/{room_of(name)}" for name in sources(root, *FLOORS)}
    return {f"{package}/{room}" for package, floors in FLOORS.items() for room in floors} - found


def borrowing_complaints(root: Path) -> Iterator[str]:
    """Test files that import test files: shared code belongs in `tests/support`."""
    paths = {path.relative_to(root).as_posix(): path for path in sorted((root / "tests").rglob("*.py"))}
    files = {module_of(name): name for name in paths}
    for name, path in paths.items():
        if MAY_BORROW.search(text := path.read_text(encoding="utf-8")):
            wanted = imports_of(name, parsed(text), files)
            yield from (f"{name}: imports {other}, a test file" for other in wanted if is_test_file(other))


def sharing_complaints(root: Path) -> Iterator[str]:
    """Imports of the second judge beyond its own room and its libraries: it shares no code of ours."""
    allowed = {*sys.stdlib_module_names, "msgpack", "numpy", "shapely"}
    for name, tree in sources(root, "clew/judge").items():
        for node in ast.walk(tree):
            modules = [alias.name for alias in node.names] if isinstance(node, ast.Import) else []
            if isinstance(node, ast.ImportFrom):
                modules = ["." if node.level else str(node.module)]
            for module in modules:
                if module.partition(".")[0] not in allowed and not module.startswith("clew.judge"):
                    yield f"{name}: imports {module}, which the second judge must not share"


def is_test_file(name: str) -> bool:
    return name.rpartition("/")[2].startswith("test_")


def crowd_complaints(root: Path) -> Iterator[str]:
    """Folders with too many of our files for one subject; `__init__.py` does not count."""
    for package in (*FLOORS, "tests"):
        paths = (path for path in (root / package).rglob("*") if path.suffix in SOURCES)
        held = Counter(path.parent for path in paths if path.name != "__init__.py")
        for folder, count in sorted(held.items()):
            name = folder.relative_to(root).as_posix()
            if count > FILES_MAX and not name.startswith(MAY_HOLD_MORE):
                yield f"{name}: holds {count} files, more than {FILES_MAX}"


def nameless_folders(root: Path) -> list[str]:
    """Folders with Python files that are no packages."""
    folders = {path.parent for package in (*FLOORS, "tests") for path in (root / package).rglob("*.py")}
    above = {parent for folder in folders for parent in folder.relative_to(root).parents if parent != Path()}
    wanted = folders | {root / parent for parent in above}
    return sorted(each.relative_to(root).as_posix() for each in wanted if not (each / "__init__.py").exists())


def test_imports_between_rooms_point_down() -> None:
    assert list(floor_complaints(ROOT)) == []


def test_there_is_no_import_cycle() -> None:
    assert list(cycle_complaints(ROOT)) == []


def test_every_floor_has_a_file() -> None:
    assert idle_floors(ROOT) == set()


def test_no_test_file_imports_another() -> None:
    assert list(borrowing_complaints(ROOT)) == []


def test_the_second_judge_imports_nothing_of_ours() -> None:
    assert list(sharing_complaints(ROOT)) == []


def test_no_folder_holds_too_many_files() -> None:
    assert list(crowd_complaints(ROOT)) == []


def test_every_folder_with_python_is_a_package() -> None:
    assert nameless_folders(ROOT) == []


def plant(root: Path, files: dict[str, str]) -> None:
    for name, source in files.items():
        path = root / name
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text(source, encoding="utf-8")


@pytest.mark.parametrize(
    ("name", "source", "imported"),
    [
        ("agents/body/a.py", "from agents.strand.b import f", "agents/strand/b.py"),  # up
        ("clew/log/a.py", "def f():\n    import clew.story.b", "clew/story/b.py"),  # up, within a function
        ("clew/swarm/a.py", "from clew.story import b", "clew/story/b.py"),  # across
        ("clew/page/a.py", "from clew.page.serve import b", "clew/page/serve/b.py"),  # into a room within
        ("protocol/keys.py", "from protocol.wire.b import f", "protocol/wire/b.py"),  # from beside the rooms
        ("world/record/a.py", "from world.core import f", "world/core.py"),  # to beside the rooms
    ],
)
def test_planted_import_that_points_up_is_found(
    tmp_path: Path, name: str, source: str, imported: str
) -> None:
    plant(tmp_path, {name: source, imported: ""})
    assert list(floor_complaints(tmp_path)) == [f"{name}: imports {imported}, which is not below it"]


def test_planted_imports_that_point_down_or_stay_in_a_room_pass(tmp_path: Path) -> None:
    downward = {
        "protocol/wire/a.py": "from protocol.faults.b import f\nfrom protocol.wire.c import g",
        "protocol/wire/c.py": "",
        "protocol/faults/b.py": "from protocol import keys",
        "protocol/keys.py": "import protocol.frames",
        "protocol/frames.py": "",
    }
    plant(tmp_path, downward)
    assert list(floor_complaints(tmp_path)) == []


def test_planted_room_without_a_floor_is_found(tmp_path: Path) -> None:
    plant(tmp_path, {"world/attic/a.py": ""})
    assert list(floor_complaints(tmp_path)) == ["world/attic/a.py: attic/ has no floor"]


def test_planted_cycle_is_found(tmp_path: Path) -> None:
    plant(tmp_path, {"clew/log/a.py": "import clew.log.b", "clew/log/b.py": "from clew.log import c"})
    plant(tmp_path, {"clew/log/c.py": ""})
    assert list(cycle_complaints(tmp_path)) == []
    plant(tmp_path, {"clew/log/c.py": "from clew.log.a import f"})
    [said] = cycle_complaints(tmp_path)
    assert "clew/log/a.py imports clew/log/b.py" in said
    assert "clew/log/c.py imports clew/log/a.py" in said


def test_floor_without_files_is_found(tmp_path: Path) -> None:
    plant(tmp_path, {"world/judge/a.py": ""})
    assert "world/judge/" not in idle_floors(tmp_path)
    assert "world/record/" in idle_floors(tmp_path)


@pytest.mark.parametrize(
    "source",
    [
        "from tests.unit.test_b import f",
        "from tests.unit import test_b",
        "def f():\n    import tests.unit.test_b",
        "from tests.unit import (\n    a,\n    test_b,\n)",
    ],
)
def test_planted_import_of_a_test_file_is_found(tmp_path: Path, source: str) -> None:
    plant(tmp_path, {"tests/house/test_a.py": source, "tests/unit/test_b.py": ""})
    assert list(borrowing_complaints(tmp_path)) == [
        "tests/house/test_a.py: imports tests/unit/test_b.py, a test file"
    ]


@pytest.mark.parametrize(
    ("source", "module"),
    [
        ("from world.geometry.shapes import Circle", "world.geometry.shapes"),
        ("def f():\n    import protocol.frames", "protocol.frames"),
        ("from clew.log.log import Log", "clew.log.log"),
        ("from clew import log", "clew"),
        ("from ..log import Log", "."),
        ("import msgspec", "msgspec"),  # it would read our types
    ],
)
def test_planted_import_of_the_second_judge_is_found(tmp_path: Path, source: str, module: str) -> None:
    plant(tmp_path, {"clew/judge/a.py": "import json\nfrom clew.judge.b import f", "clew/judge/b.py": source})
    assert list(sharing_complaints(tmp_path)) == [
        f"clew/judge/b.py: imports {module}, which the second judge must not share"
    ]


def test_planted_import_of_support_passes(tmp_path: Path) -> None:
    plant(tmp_path, {"tests/house/test_a.py": "from tests.support.b import f", "tests/support/b.py": ""})
    assert list(borrowing_complaints(tmp_path)) == []


@pytest.mark.parametrize(
    ("folder", "kind"), [("world/judge", "py"), ("tests/processes", "py"), ("clew/page/assets", "js")]
)
def test_planted_crowded_folder_is_found(tmp_path: Path, folder: str, kind: str) -> None:
    plant(tmp_path, {f"{folder}/a{number}.{kind}": "" for number in range(FILES_MAX)})
    plant(tmp_path, {f"{folder}/__init__.py": "", f"{folder}/a.toml": ""})
    assert list(crowd_complaints(tmp_path)) == []
    plant(tmp_path, {f"{folder}/more.{kind}": ""})
    assert list(crowd_complaints(tmp_path)) == [f"{folder}: holds 17 files, more than 16"]


def test_verbs_and_mirrors_of_packages_may_hold_more(tmp_path: Path) -> None:
    plant(
        tmp_path, {f"{folder}/a{n}.py": "" for folder in ("clew/verbs", "tests/unit/clew") for n in range(30)}
    )
    assert list(crowd_complaints(tmp_path)) == []


def test_planted_folder_that_is_no_package_is_found(tmp_path: Path) -> None:
    plant(
        tmp_path,
        {"tests/__init__.py": "", "tests/unit/world/test_a.py": "", "tests/unit/world/__init__.py": ""},
    )
    assert nameless_folders(tmp_path) == ["tests/unit"]
