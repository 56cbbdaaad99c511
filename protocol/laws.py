"""The laws of this process by name: ours, those of packages and files, and those that Python code registers.

Rule 1: nobody takes a name of ours, so `certified` is the same law everywhere.
Rule 2: a law is loaded when it is looked up first, which shells do before a core starts.
Rule 3: what a law of a package or a file prints goes to stderr: stdout is for the results of our commands,
        and for what our own processes tell each other.
"""

import re
import sys
from collections.abc import Callable, Iterator
from contextlib import contextmanager, redirect_stdout
from functools import partial, wraps
from importlib.metadata import EntryPoint, entry_points
from inspect import signature
from typing import Any

from protocol import law_files
from protocol.errors import UsageError, is_failure
from protocol.files.names import did_you_mean
from protocol.mission import LAW_NAME

GROUP = "clew.laws"
OURS = {
    name: EntryPoint(name, f"agents.navigation.laws:{name}", GROUP)
    for name in ("certified", "printed", "resultant")
}
_registered: dict[str, Any] = {}
_loaded: dict[str, Any] = {}


def register(name: str, law: Any) -> None:  # noqa: ANN401 - `clew.register_law` has the type
    """Add a law of this process, or replace one.

    Raises:
        UsageError: the name is ours, or no name of a law; or the law cannot be called.
    """
    if name in OURS or not re.fullmatch(LAW_NAME, name):
        raise UsageError(f"a law's name must match {LAW_NAME} and not be {', '.join(OURS)}, got {name!r}")
    _registered[name] = _called(name, law)


def names() -> list[str]:
    """All that this process can look up: ours first."""
    return [*OURS, *sorted({*_registered, *(each.name for each in entry_points(group=GROUP))} - OURS.keys())]


def check(name: str, *, in_processes: bool = False) -> None:
    """Refuse a name that no law has here.

    Args:
        name: the law's name.
        in_processes: whether other processes have to find it, which do not know what is registered here.

    Raises:
        UsageError: there is no such law.
    """
    if law_files.is_of_file(name):
        law_files.read(name)
        return
    if name in OURS or (name in _registered and not in_processes) or entry_points(group=GROUP, name=name):
        return
    if name in _registered:
        raise UsageError(
            f"the law {name!r} is registered in this process alone; robots are processes of their own, "
            f"which find it by FILE.py:NAME or an entry point of the group {GROUP}"
        )
    known = names()
    refusal = f"must be one of {', '.join(known)}, got {name!r}{did_you_mean(name, known)}"
    raise UsageError(f"{refusal} (laws installed for {sys.executable})")


def find(name: str) -> Any:  # noqa: ANN401 - the robots' code knows the type
    """The law with this name.

    Raises:
        UsageError: there is none here, or it cannot be loaded.
    """
    if name in _registered:
        return _registered[name]
    if name not in _loaded:
        _loaded[name] = _load(name)
    return _loaded[name]


@contextmanager
def overheard(name: str, hear: Callable[[Any], None]) -> Iterator[None]:
    """While this lasts, `hear` gets what the law of this name is given, and then the law gets it.

    Raises:
        UsageError: as `find`.
    """
    law, before = find(name), _registered.get(name)

    def asked(seen: Any) -> Any:  # noqa: ANN401 - as of `find`
        hear(seen)
        return law(seen)

    _registered[name] = asked
    try:
        yield
    finally:
        del _registered[name]
        if before is not None:
            _registered[name] = before


def _load(name: str) -> Any:  # noqa: ANN401 - as of `find`
    where, load = _source(name)
    try:
        with redirect_stdout(sys.stderr):
            law = load()
    except BaseException as error:  # whatever a user's module does when it is imported
        if not is_failure(error):
            raise
        why = f"{type(error).__name__}: {error}"
        raise UsageError(f"the law {name!r} cannot be loaded from {where}: {why}") from error
    law = _called(name, law)
    return law if name in OURS else _printing_to_stderr(law)


def _printing_to_stderr(law: Callable[[Any], Any]) -> Callable[[Any], Any]:
    """The same law by rule 3."""

    @wraps(law, updated=())
    def asked(seen: Any) -> Any:  # noqa: ANN401 - as of `find`
        with redirect_stdout(sys.stderr):
            return law(seen)

    return asked


def _source(name: str) -> tuple[str, Callable[[], Any]]:
    """Where a law comes from, and what loads it."""
    found = {OURS[name]} if name in OURS else {*entry_points(group=GROUP, name=name)}
    try:
        if law_files.is_of_file(name):
            return str(law_files.read(name)[0]), partial(law_files.load, name)
        if not found:
            check(name)
    except UsageError as error:
        raise UsageError(f"the law {error}") from error
    values = sorted({each.value for each in found})
    if len(values) > 1:
        raise UsageError(f"the law {name!r} comes from several packages: {', '.join(values)}")
    return values[0], found.pop().load


def _called(name: str, law: Any) -> Any:  # noqa: ANN401 - as of `find`
    """The law, if it is of the right shape; what it answers is for the robot to check."""
    what = f"the law {name!r} must be a function with one argument, what is seen"
    if not callable(law) or isinstance(law, type):
        raise UsageError(f"{what}, got {'a class' if isinstance(law, type) else type(law).__name__}")
    try:
        signature(law).bind(None)
    except TypeError as error:
        raise UsageError(f"{what}, got one with {signature(law)}: {error}") from error
    except ValueError:
        pass  # a function in C may have no signature
    return law
