"""Laws of single files: a name says what is in the file, which is run only when the law is looked up."""

import shutil
from collections.abc import Callable
from pathlib import Path

import pytest

from protocol import law_files, laws
from protocol.errors import UsageError

LAW = "def mine(seen):\n    return 'none'\n"
NAME = "mylaw.py:mine@dbc30b67"


@pytest.fixture
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A folder with a law; this process has been told of no other."""
    monkeypatch.setattr(law_files, "_folders", {})
    monkeypatch.setattr(laws, "_loaded", {})
    (tmp_path / "mylaw.py").write_text(LAW)
    return tmp_path


@pytest.mark.parametrize("said", ["mylaw.py:mine", "./mylaw.py:mine", NAME])
def test_a_law_of_a_file_has_a_name_that_says_what_is_in_the_file(folder: Path, said: str) -> None:
    assert law_files.named(said, folder) == NAME
    assert law_files.named(f"{folder}/{said}", Path("elsewhere")) == NAME
    laws.check(NAME, in_processes=True)
    assert laws.find(NAME)(None) == "none"
    assert laws.find(NAME) is laws.find(NAME)


@pytest.mark.parametrize("said", ["certified", "mine", "certifid"])
def test_other_laws_keep_their_names(said: str) -> None:
    assert law_files.named(said, Path()) == said
    assert law_files.copies(said) == {}


@pytest.mark.parametrize(
    ("said", "why"),
    [
        ("none.py:mine", r".*/none\.py: cannot be read: No such file or directory"),
        ("folder.py:mine", r".*/folder\.py: cannot be read: Is a directory"),
        ("my\0law.py:mine", r".*/my\0law\.py: cannot be read: no file can have this name"),
        ("mylaw.py", r"must be a name, or FILE\.py:NAME such as mylaw\.py:mine, got 'mylaw\.py'"),
        ("./mylaw", r"must be a name, or FILE\.py:NAME .*, got '\./mylaw'"),
        ("mylaw.py:not a name", r"must be a name, or FILE\.py:NAME .*"),
        ("mylaw.txt:mine", r"must be a name, or FILE\.py:NAME .*"),
        ("mylaw.py:mine@00000000", rf"mylaw\.py:mine@00000000: the file was changed; its law is {NAME} now"),
    ],
)
def test_what_names_no_law_of_a_file_is_refused_in_one_line(folder: Path, said: str, why: str) -> None:
    (folder / "folder.py").mkdir()
    with pytest.raises(UsageError, match=f"^{why}$"):
        law_files.named(said, folder)


@pytest.mark.parametrize(
    ("text", "why"),
    [
        ("def mien(seen): ...", r"cannot be loaded from .*/mylaw\.py: AttributeError: it has no 'mine'; did"),
        ("def mine(seen)", r"cannot be loaded from .*: SyntaxError: expected ':' \(mylaw\.py, line 1\)"),
        ("import nowhere", "cannot be loaded from .*: ModuleNotFoundError: No module named 'nowhere'"),
        ("raise SystemExit(0)", "cannot be loaded from .*: SystemExit: 0"),
        ("mine = 3", "must be a function with one argument, what is seen, got int"),
        ("class mine: ...", "must be a function with one argument, what is seen, got a class"),
        (
            "def mine(): ...",
            r"must be a function with one argument, what is seen, got one with \(\): too many positional",
        ),
        ("def mine(seen, ways): ...", r"must be .* \(seen, ways\): missing a required argument: 'ways'"),
    ],
)
def test_a_file_without_a_law_of_that_name_is_refused_when_it_is_looked_up(
    folder: Path, text: str, why: str
) -> None:
    (folder / "mylaw.py").write_text(text)
    name = law_files.named("mylaw.py:mine", folder)
    with pytest.raises(UsageError, match=f"^the law '{name}' {why}"):
        laws.find(name)


@pytest.mark.parametrize(
    "text",
    ["import math as mime", "mien = 3", "class Mine: ...", "from math import fsum as mines", "mine_ = len"],
)
def test_what_can_be_no_law_is_not_suggested(folder: Path, text: str) -> None:
    (folder / "mylaw.py").write_text(text)
    with pytest.raises(UsageError, match=r"it has no 'mine'$"):
        laws.find(law_files.named("mylaw.py:mine", folder))


def test_a_file_is_not_run_before_its_law_is_looked_up(folder: Path) -> None:
    (folder / "mylaw.py").write_text("1 / 0")
    name = law_files.named("mylaw.py:mine", folder)
    laws.check(name)
    assert law_files.copies(name) == {"mylaw.py": b"1 / 0"}
    with pytest.raises(UsageError, match="ZeroDivisionError"):
        laws.find(name)
    assert [path.name for path in folder.iterdir()] == ["mylaw.py"], "and nothing is left beside it"


def test_a_law_of_a_file_may_have_a_dataclass(folder: Path) -> None:
    imports = "from __future__ import annotations\nfrom dataclasses import dataclass\n"
    (folder / "mylaw.py").write_text(f"{imports}@dataclass\nclass Way:\n    length_m: float\n{LAW}")
    assert laws.find(law_files.named("mylaw.py:mine", folder))(None) == "none"


def _told(folder: Path) -> None:
    law_files.look_in(folder)


def _named(folder: Path) -> None:
    (folder / "other.py").touch()
    law_files.named("other.py:any", folder)


@pytest.mark.parametrize("tell", [_told, _named])
def test_a_file_is_found_in_every_folder_that_was_told_if_it_has_that_content(
    folder: Path, tell: Callable[[Path], None]
) -> None:
    elsewhere = folder / "elsewhere"
    elsewhere.mkdir()
    shutil.move(folder / "mylaw.py", elsewhere / "mylaw.py")
    with pytest.raises(UsageError, match=f"^{NAME}: its file is not here, or was changed$"):
        laws.check(NAME)
    with pytest.raises(UsageError, match=f"^the law {NAME}: its file is not here, or was changed$"):
        laws.find(NAME)
    tell(elsewhere)
    laws.check(NAME)
    (folder / "mylaw.py").write_text("another")
    _told(folder)
    laws.check(NAME)


def test_a_name_that_comes_over_the_network_leads_out_of_no_folder_that_was_told(folder: Path) -> None:
    (folder / "run").mkdir()
    law_files.look_in(folder / "run")
    with pytest.raises(UsageError, match="its file is not here"):
        laws.find(f"../{NAME}")


def test_two_files_with_one_name_are_two_laws(folder: Path) -> None:
    first = law_files.named("mylaw.py:mine", folder)
    (folder / "other").mkdir()
    (folder / "other" / "mylaw.py").write_text("def mine(seen):\n    return 'other'\n")
    second = law_files.named("other/mylaw.py:mine", folder)
    assert [laws.find(name)(None) for name in (first, second)] == ["none", "other"]
