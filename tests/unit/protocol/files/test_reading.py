"""Files named by users: they are read within bounds, or refused in one line."""

import os
from collections.abc import Callable
from pathlib import Path

import pytest

from protocol.errors import UsageError
from protocol.faults.plan import load as load_plan
from protocol.files.names import did_you_mean
from protocol.files.opening import WRITTEN_BYTES_MAX, open_regular, read_bytes
from protocol.network.session import read_session
from world.scenario.scenario import load as load_scenario

LOADERS = [load_scenario, load_plan]
NESTED = {
    "lists": "a = " + "[" * 300 + "]" * 300,
    "many lists": "a = " + "[" * 100_000 + "]" * 100_000,
    "tables": "a = " + "{a = " * 300 + "1" + "}" * 300,
    "a key": ".".join(["a"] * 5_000) + " = 1",
    "a key in quotes": ".".join(['"a b"'] * 5_000) + " = 1",
    "a heading": "[" + ".".join(["a"] * 5_000) + "]",
    "a key of a megabyte": ".".join(["a"] * 500_000) + " = 1",
}


def refusal(load: Callable[[str], object], path: Path) -> str:
    with pytest.raises(UsageError) as refused:
        load(str(path))
    assert str(refused.value).count("\n") == 0
    return str(refused.value).removeprefix(str(path))


@pytest.mark.parametrize("text", NESTED.values(), ids=NESTED)
@pytest.mark.parametrize("load", LOADERS)
def test_a_file_that_is_nested_too_deep_is_refused_in_one_line(
    load: Callable[[str], object], text: str, tmp_path: Path
) -> None:
    path = tmp_path / "deep.toml"
    path.write_text(text, encoding="utf-8")
    assert "64" in refusal(load, path)


def test_a_scene_that_is_nested_too_deep_is_refused_in_one_line(tmp_path: Path) -> None:
    for depth in (100, 900, 100_000):
        path = tmp_path / "deep.json"
        path.write_text('{"a":' + "[" * depth + "]" * depth + "}", encoding="utf-8")
        assert refusal(load_scenario, path) == ": is not JSON: it is nested deeper than 64"


def test_a_scene_that_is_empty_is_named_as_that(tmp_path: Path) -> None:
    (path := tmp_path / "empty.json").write_text("\n", encoding="utf-8")
    assert refusal(load_scenario, path) == ": is not JSON: it is empty"


@pytest.mark.parametrize("number", ["9" * 5_000, "0x" + "f" * 5_000, "-" + "9" * 30])
def test_a_number_that_no_field_can_hold_is_refused_in_one_line(number: str, tmp_path: Path) -> None:
    path = tmp_path / "large.toml"
    path.write_text(f"name = {number}", encoding="utf-8")
    assert refusal(load_scenario, path).startswith(": is not TOML: ")


@pytest.mark.parametrize("load", LOADERS)
def test_a_file_that_is_not_regular_is_refused_without_blocking(
    load: Callable[[str], object], tmp_path: Path
) -> None:
    os.mkfifo(tmp_path / "fifo.toml")
    (tmp_path / "zero.toml").symlink_to("/dev/zero")
    for name in ("fifo.toml", "zero.toml"):
        assert refusal(load, tmp_path / name) == ": cannot be read: it is no regular file"
    (tmp_path / "folder.toml").mkdir()
    assert refusal(load, tmp_path / "folder.toml") == ": cannot be read: Is a directory"


@pytest.mark.parametrize("load", LOADERS)
def test_a_file_that_is_too_long_is_refused(load: Callable[[str], object], tmp_path: Path) -> None:
    path = tmp_path / "long.toml"
    path.write_bytes(b"#" * (WRITTEN_BYTES_MAX + 1))
    assert refusal(load, path) == f": cannot be read: it is longer than {WRITTEN_BYTES_MAX} bytes"


def test_a_session_that_is_a_device_is_refused(tmp_path: Path) -> None:
    (tmp_path / "world.json").symlink_to("/dev/zero")
    with pytest.raises(UsageError, match="no regular file"):
        read_session(tmp_path / "world.json")


def test_a_file_is_read_up_to_its_limit(tmp_path: Path) -> None:
    path = tmp_path / "file"
    path.write_bytes(b"12345")
    assert read_bytes(path, 5) == b"12345"
    with pytest.raises(OSError, match="longer than 4 bytes"):
        read_bytes(path, 4)
    with open_regular(path) as file:
        assert file.read() == b"12345"


@pytest.mark.parametrize(("word", "near"), [("trak", "; did you mean 'track'?"), ("extra", "")])
def test_only_a_name_that_is_near_is_suggested(word: str, near: str) -> None:
    assert did_you_mean(word, ["shape", "id", "track", "radius_m"]) == near
