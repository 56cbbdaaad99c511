"""Laws by name: ours, registered ones, and those of installed packages."""

import sys
from pathlib import Path

import pytest

from protocol import laws
from protocol.errors import UsageError
from tests.support.installed import install


@pytest.fixture
def installed(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A folder on the path, as `pip install --target` makes it; what is loaded from it is forgotten."""
    monkeypatch.syspath_prepend(tmp_path)
    monkeypatch.setattr(laws, "_loaded", {})
    monkeypatch.setattr(laws, "_registered", {})
    return tmp_path


def test_a_law_of_an_installed_package_is_found_by_its_name(installed: Path) -> None:
    (installed / "shore.py").write_text("def along(seen): return 'none'\n")
    install(installed, "shore", {"along": "shore:along"})
    assert laws.names() == ["certified", "printed", "resultant", "along"]
    laws.check("along", in_processes=True)
    assert laws.find("along")(None) == "none"
    assert laws.find("along") is laws.find("along")


@pytest.mark.parametrize(
    ("value", "why"),
    [
        ("nowhere:law", "ModuleNotFoundError: No module named 'nowhere'"),
        ("unwell:law", "ZeroDivisionError: division by zero"),
        ("well:law", "AttributeError: module 'well' has no attribute 'law'"),
        ("rusty:law", "PanicException: index out of bounds"),
    ],
)
def test_a_law_that_cannot_be_loaded_is_refused_in_one_line(installed: Path, value: str, why: str) -> None:
    (installed / "unwell.py").write_text("1 / 0\n")
    (installed / "well.py").touch()
    (installed / "rusty.py").write_text(
        "class PanicException(BaseException): pass\nraise PanicException('index out of bounds')\n"
    )
    install(installed, "some", {"mine": value})
    with pytest.raises(UsageError, match=f"^the law 'mine' cannot be loaded from {value}: {why}$"):
        laws.find("mine")


def test_an_installed_law_that_is_no_function_is_refused(installed: Path) -> None:
    (installed / "numeral.py").write_text("law = 3\n")
    install(installed, "some", {"mine": "numeral:law"})
    with pytest.raises(
        UsageError, match="'mine' must be a function with one argument, what is seen, got int"
    ):
        laws.find("mine")


def test_a_name_that_two_packages_give_to_different_laws_is_refused(installed: Path) -> None:
    install(installed, "one", {"mine": "one:law"})
    install(installed, "two", {"mine": "two:law"})
    with pytest.raises(UsageError, match="'mine' comes from several packages: one:law, two:law"):
        laws.find("mine")


def test_no_package_takes_a_name_of_ours(installed: Path) -> None:
    install(installed, "one", {"printed": "one:law", "certified": "one:law"})
    assert [laws.find(name).__module__ for name in laws.OURS] == ["agents.navigation.laws"] * 3
    assert laws.names() == list(laws.OURS)


@pytest.mark.parametrize("name", ["certified", "printed", "", "Mine", "my law", "no\nlaw", "3d"])
def test_no_code_registers_a_name_of_ours_or_none_at_all(name: str) -> None:
    with pytest.raises(UsageError, match=r"a law's name must match .* and not be certified, printed"):
        laws.register(name, print)


@pytest.mark.usefixtures("installed")
def test_a_registered_law_can_be_replaced_and_is_not_for_other_processes() -> None:
    laws.register("mine", print)
    laws.register("mine", len)
    assert (laws.find("mine"), laws.names()[-1]) == (len, "mine")
    laws.check("mine")
    with pytest.raises(UsageError, match="'mine' is registered in this process alone"):
        laws.check("mine", in_processes=True)
    with pytest.raises(UsageError, match="'other' must be a function"):
        laws.register("other", 3)


@pytest.mark.usefixtures("installed")
def test_an_unknown_law_is_refused_with_the_names_that_there_are() -> None:
    laws.register("mine", print)
    there = "must be one of certified, printed, resultant, mine, got 'certifid'; did you mean 'certified'"
    with pytest.raises(UsageError, match=f"^the law {there}"):
        laws.find("certifid")
    with pytest.raises(UsageError, match=rf"^{there}\? \(laws installed for {sys.executable}\)$"):
        laws.check("certifid")
