"""Laws of single Python files: `FILE.py:NAME`, and by their whole name `FILE.py:NAME@HASH`.

Rule 1: a scenario, a mission and a log have the whole name. Its hash is that of the file's content, so a run,
        its robots and its replay have the same law, or none.
Rule 2: the run's folder has a copy of the file, under the same name. A file is looked for in all folders that
        this process was told of.
Rule 3: a file is read when it is named, and run when its law is looked up. The world and readers of logs
        never run it.
"""

import re
import sys
from hashlib import blake2b
from pathlib import Path
from types import ModuleType
from typing import Any

from protocol.errors import UsageError
from protocol.files.names import did_you_mean
from protocol.files.opening import WRITTEN_BYTES_MAX, read_bytes

_SAID = re.compile(r"([^:]+[.]py):([A-Za-z_][A-Za-z0-9_]*)(?:@([0-9a-f]{8}))?")

_folders: dict[Path, None] = {}
"""Where files are looked for, in the order in which they were told."""


def is_of_file(law: str) -> bool:
    """Whether this can only mean a law of a file: no name has these characters."""
    return any(each in law for each in ".:/")


def look_in(folder: Path) -> None:
    """Look for files in this folder, too (rule 2). A link, as `runs/latest`, is followed now, not later."""
    _folders.setdefault(folder.resolve())


def named(said: str, folder: Path) -> str:
    """The whole name of a law that somebody named, with a path from this folder; other laws keep their names.

    Raises:
        UsageError: the file cannot be read, or has another hash; or no file and law are named.
    """
    if not is_of_file(said):
        return said
    said_file, law, wanted = _parts(said)
    path = folder / said_file
    try:
        name = f"{path.name}:{law}@{_hash(read_bytes(path, WRITTEN_BYTES_MAX))}"
    except OSError as error:
        raise UsageError(f"{path}: cannot be read: {error.strerror}") from error
    if wanted is not None and not name.endswith(wanted):
        raise UsageError(f"{said}: the file was changed; its law is {name} now")
    look_in(path.parent)
    return name


def read(name: str) -> tuple[Path, bytes]:
    """The file of a law, given by its whole name, and the content that the name says.

    Raises:
        UsageError: there is no such file here.
    """
    file, _, wanted = _parts(name)
    for path in (folder / Path(file).name for folder in _folders):
        try:
            text = read_bytes(path, WRITTEN_BYTES_MAX)
        except OSError:
            continue
        if _hash(text) == wanted:
            return path, text
    raise UsageError(f"{name}: its file is not here, or was changed")


def copies(name: str) -> dict[str, bytes]:
    """The files to keep with a run under this law, by their names there (rule 2).

    Raises:
        UsageError: as `read`.
    """
    if not is_of_file(name):
        return {}
    path, text = read(name)
    return {path.name: text}


def load(name: str) -> Any:  # noqa: ANN401 - `laws` checks what it is
    """Run the file of a law, given by its whole name; returns the law. The file may raise anything."""
    (path, text), (_, law, wanted) = read(name), _parts(name)
    module = ModuleType(f"clew_law_{wanted}")
    vars(module).update(__file__=str(path))
    sys.modules.update({module.__name__: module})  # dataclasses look there for their module
    exec(compile(text, str(path), "exec"), vars(module))  # noqa: S102 - the user names the file to run it
    if not hasattr(module, law):
        raise AttributeError(f"it has no {law!r}{did_you_mean(law, _functions_of(module))}")
    return getattr(module, law)


def _functions_of(module: ModuleType) -> list[str]:
    """The names of what a file defines and can be called: a law is no class, nor what the file imports."""
    return [
        name
        for name, each in vars(module).items()
        if callable(each) and not isinstance(each, type)
        if getattr(each, "__module__", None) == module.__name__
    ]


def _parts(said: str) -> tuple[str, str, str | None]:
    """The file, the name in it, and the hash if there is one."""
    match = _SAID.fullmatch(said)
    if match is None:
        raise UsageError(f"must be a name, or FILE.py:NAME such as mylaw.py:mine, got {said!r}")
    return match[1], match[2], match[3]


def _hash(text: bytes) -> str:
    return blake2b(text, digest_size=4).hexdigest()
