"""The files of a run: private for any umask, and never written through a link."""

import os
from collections.abc import Iterator
from pathlib import Path

import pytest

from protocol.errors import UsageError
from protocol.files.writing import check_ours, make_folder, open_private, write_whole


def mode_of(path: Path) -> int:
    return path.stat().st_mode & 0o777


@pytest.fixture(params=[0o000, 0o022, 0o277], ids=oct)
def umask(request: pytest.FixtureRequest) -> Iterator[None]:
    before = os.umask(request.param)
    yield
    os.umask(before)


@pytest.mark.usefixtures("umask")
def test_files_and_folders_are_private_to_the_user(tmp_path: Path) -> None:
    folder = tmp_path / "run"
    make_folder(folder)
    write_whole(folder / "whole", b"1")
    with open_private(folder / "made", "x") as file:
        file.write(b"1")
    with open_private(folder / "grown", "a") as file:
        file.write(b"1")
    assert mode_of(folder) == 0o700
    assert {mode_of(path) for path in folder.iterdir()} == {0o600}


def test_an_existing_folder_keeps_its_mode(tmp_path: Path) -> None:
    tmp_path.chmod(0o755)
    make_folder(tmp_path)
    assert mode_of(tmp_path) == 0o755


def test_a_link_is_replaced_and_its_target_stays_unchanged(tmp_path: Path) -> None:
    (tmp_path / "target").write_bytes(b"theirs")
    (tmp_path / "link").symlink_to("target")
    write_whole(tmp_path / "link", b"ours")
    assert (tmp_path / "target").read_bytes() == b"theirs"
    assert (tmp_path / "link").read_bytes() == b"ours"
    assert not (tmp_path / "link").is_symlink()


@pytest.mark.parametrize("mode", ["x", "a", "r+"])
def test_a_link_is_never_opened_and_neither_it_nor_a_file_taken_for_a_folder(
    tmp_path: Path, mode: str
) -> None:
    (tmp_path / "target").write_bytes(b"theirs")
    (tmp_path / "link").symlink_to("target")
    with pytest.raises(OSError, match="link"):
        open_private(tmp_path / "link", mode)
    (tmp_path / "folder").symlink_to(tmp_path)
    for name, place in (("folder", "folder"), ("target", "target"), ("target/deep/run", "target")):
        with pytest.raises(FileExistsError, match=f"{tmp_path}/{place} is no folder"):
            make_folder(tmp_path / name)


def test_a_path_that_is_not_a_file_is_refused_and_nothing_is_left(tmp_path: Path) -> None:
    os.mkfifo(tmp_path / "fifo")
    with pytest.raises(OSError, match="no file"):
        write_whole(tmp_path / "fifo", b"")
    with pytest.raises(OSError, match=r"No such file or directory: '.*/nowhere/file'"):
        write_whole(tmp_path / "nowhere" / "file", b"")
    assert [path.name for path in tmp_path.iterdir()] == ["fifo"]


def test_a_failed_write_leaves_the_old_file(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    write_whole(tmp_path / "file", b"before")

    def full(_: Path, __: Path) -> Path:
        raise OSError(28, "No space left on device")

    monkeypatch.setattr(Path, "replace", full)
    with pytest.raises(OSError, match=r"No space left on device: '.*/file'"):
        write_whole(tmp_path / "file", b"after")
    assert [(path.name, path.read_bytes()) for path in tmp_path.iterdir()] == [("file", b"before")]


MARK = b"made by us"


@pytest.mark.parametrize(
    "content", [b"", b"%PDF " + MARK, b"x" * 9000 + MARK, MARK + b"x" * 9000, b"x" * 5000 + MARK], ids=len
)
def test_a_file_of_ours_and_an_empty_one_may_be_replaced(tmp_path: Path, content: bytes) -> None:
    check_ours(tmp_path / "file", MARK)
    (tmp_path / "file").write_bytes(content)
    check_ours(tmp_path / "file", MARK)


@pytest.mark.parametrize("content", [b"x", b"x" * 9000, b"x" * 9000 + MARK + b"x" * 9000])
def test_a_file_of_others_must_not_be_replaced(tmp_path: Path, content: bytes) -> None:
    (tmp_path / "file").write_bytes(content)
    with pytest.raises(
        UsageError, match=r"^cannot write .*/file: it is there, and bears no mark of Clew, so "
    ):
        check_ours(tmp_path / "file", MARK)


def test_what_is_no_file_must_not_be_replaced(tmp_path: Path) -> None:
    os.mkfifo(tmp_path / "pipe")
    (tmp_path / "far").symlink_to("/dev/zero")
    for name in ("pipe", "far", "."):
        with pytest.raises(UsageError, match=r"^cannot write .*: (it is no regular file|Is a directory)$"):
            check_ours(tmp_path / name, MARK)
