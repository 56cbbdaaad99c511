"""Fixtures for pytest: a fleet to break, rehearsed or live, with one interface. `docs/testing.md`.

Rule 1: `clew_rehearsal` rehearses and `clew_fleet` launches real processes; `--clew-stage` decides for both.
Rule 2: a fleet has its own folder and sockets, so tests may run in parallel.
Rule 3: nothing of Clew is loaded before a test asks for a fleet.
Rule 4: a test that ends well has failed all the same if a fault of its fleet never struck, since it has not
        tested that fault. `must_strike=False` allows it.
Rule 5: what cannot be done as a test asks is said in one line, at the line of the test that asks for it.
"""

import shlex
from collections.abc import Iterable, Iterator, Sequence
from inspect import iscoroutine, signature
from pathlib import Path
from typing import TYPE_CHECKING, Any

import pytest

if TYPE_CHECKING:
    from clew.api.fleet import Fleet

STAGES = REHEARSAL, LIVE = ("rehearsal", "live")
MARK = "clew"
OPTIONS = ("scenario", "robots", "seeds", "faults", "speed", "law", "deployment", "time_s_max", "must_strike")
OURS = Path(__file__).parent
SPEED = "max"  # of live fleets: as fast as the robots answer
_FLEETS = pytest.StashKey[dict[str, "Fleet"]]()
_UNSTRUCK = pytest.StashKey[bool]()


def pytest_addoption(parser: pytest.Parser) -> None:
    """The options of the command line."""
    group = parser.getgroup("clew", "fleets of robots")
    group.addoption("--clew-seed", type=int, metavar="N", help="the seed of all fleets, instead of their own")
    group.addoption(
        "--clew-stage",
        choices=STAGES,
        help="where fleets run: rehearsed in virtual time, or live as real processes; "
        "default: clew_rehearsal is rehearsed, clew_fleet is live",
    )
    group.addoption(
        "--clew-no-shrink",
        action="store_true",
        help="do not play a failing test again with fewer faults: quicker, and all its faults are shown",
    )


def pytest_configure(config: pytest.Config) -> None:
    """The marker."""
    said = "what the fleet of a test is made of; seeds: one test for each"
    config.addinivalue_line("markers", f"{MARK}({', '.join(f'{each}=...' for each in OPTIONS)}): {said}")


def pytest_generate_tests(metafunc: pytest.Metafunc) -> None:
    """One test for each seed."""
    asked = _asked(metafunc.definition)
    if "clew_seed" in metafunc.fixturenames and "seeds" in asked:
        only = metafunc.config.getoption("--clew-seed")
        if not isinstance(asked["seeds"], Iterable):
            raise _refusal(
                metafunc.definition.nodeid, f"seeds must be a list or a range, got {asked['seeds']!r}"
            )
        seeds: Sequence[int] = list(asked["seeds"]) if only is None else [only]
        if not seeds:  # pytest would skip the test
            raise _refusal(metafunc.definition.nodeid, f"seeds must not be empty, got {asked['seeds']!r}")
        metafunc.parametrize("clew_seed", seeds, ids=[f"seed={seed}" for seed in seeds])


@pytest.fixture
def clew_seed(request: pytest.FixtureRequest) -> int:
    """The seed of the fleet."""
    only: int | None = request.config.getoption("--clew-seed")
    return 1 if only is None else only


@pytest.fixture
def clew_rehearsal(request: pytest.FixtureRequest, clew_seed: int, tmp_path: Path) -> "Iterator[Fleet]":
    """A fleet in virtual time; `--clew-stage=live` makes it live."""
    yield from _fleet(request, REHEARSAL, clew_seed, tmp_path / "clew_rehearsal")


@pytest.fixture
def clew_fleet(request: pytest.FixtureRequest, clew_seed: int, tmp_path: Path) -> "Iterator[Fleet]":
    """A fleet of real processes; `--clew-stage=rehearsal` rehearses it."""
    yield from _fleet(request, LIVE, clew_seed, tmp_path / "clew_fleet")


@pytest.hookimpl(wrapper=True)
def pytest_pyfunc_call(pyfuncitem: pytest.Function) -> Iterator[None]:
    """Fail a test whose fault never struck (rule 4); of an error of its own, show its own lines (rule 5)."""
    try:
        called: Any = yield
    except Exception as error:
        if pyfuncitem.stash.get(_FLEETS, {}) and isinstance(error, _expected()):
            raise _without_ours(error) from None
        raise
    for fleet in pyfuncitem.stash.get(_FLEETS, {}).values():
        _check_struck(pyfuncitem, fleet)
    return called  # type: ignore[no-any-return] # as a hook wrapper passes it on


@pytest.hookimpl(wrapper=True)
def pytest_runtest_makereport(item: pytest.Item, call: pytest.CallInfo[None]) -> Iterator[None]:
    """Say what became of the fleets of a failed test."""
    report: Any = yield
    fleets = item.stash.get(_FLEETS, {})
    if call.when == "call" and report.failed and call.excinfo is not None and fleets:
        from clew.api.failing import told  # noqa: PLC0415 - late, by rule 3

        for name, fleet in fleets.items():
            try:
                said = "\n".join(told(_test(item, name, fleet, call.excinfo.value), fleet))
            except Exception as error:  # the test's own failure must still be shown
                said = f"nothing more can be said of it: {type(error).__name__}: {error}"
            report.sections.append((f"{name}, seed {fleet.asked.seed}", said))
    return report  # type: ignore[no-any-return] # the report that a hook wrapper passes on


def _fleet(request: pytest.FixtureRequest, stage: str, seed: int, folder: Path) -> "Iterator[Fleet]":
    try:
        fleet = _made(request.node, request.config.getoption("--clew-stage") or stage, seed, folder)
    except _expected() as error:
        raise _refusal(request.node.nodeid, error) from None
    request.node.stash.setdefault(_FLEETS, {})[str(request.fixturename)] = fleet
    yield fleet
    fleet.close()


def _mistake(item: pytest.Item, error: BaseException) -> str:
    """What a test that fails so does wrong itself; empty: its fleet may be the cause."""
    from protocol.errors import UsageError  # noqa: PLC0415 - late, by rule 3

    if item.stash.get(_UNSTRUCK, False):
        return "a fault of the test never struck"
    return "the test asks for what cannot be done" if isinstance(error, UsageError) else ""


def _refusal(test: str, why: object) -> BaseException:
    """A failure that pytest shows in one line."""
    return pytest.fail.Exception(f"{test}: {why}", pytrace=False)


def _expected() -> type[Exception]:
    """What Clew raises on purpose."""
    from protocol.errors import ClewError  # noqa: PLC0415 - late, by rule 3

    return ClewError


def _without_ours(error: Exception) -> Exception:
    """An error whose traceback ends at the caller's line."""
    at = error.__traceback__
    while at is not None and at.tb_next is not None:
        if Path(at.tb_next.tb_frame.f_code.co_filename).is_relative_to(OURS):
            at.tb_next = None
        at = at.tb_next
    return error


def _check_struck(item: pytest.Item, fleet: "Fleet") -> None:
    """Rule 4; stops a fleet that goes on, since its verdict says it."""
    if not (fleet.has_begun and fleet.plan.rules and _asked(item).get("must_strike", True)):
        return
    fleet.close()
    verdict = fleet.run.verdict
    if verdict is not None and verdict.unstruck:
        names = ", ".join(verdict.unstruck)
        item.stash[_UNSTRUCK] = True
        pytest.fail(
            f"the test has passed, but {names} never struck; if that may be: "
            "@pytest.mark.clew(must_strike=False)",
            pytrace=False,
        )


def _finished(called: object) -> None:
    """Await what a test has returned if it is a coroutine: no event loop runs when a test is reported."""
    if iscoroutine(called):
        import asyncio  # noqa: PLC0415 - late: most tests need none

        # With a factory, a runner leaves alone which loop is this thread's.
        with asyncio.Runner(loop_factory=asyncio.new_event_loop) as runner:
            runner.run(called)


def _made(
    item: pytest.Item, stage: str, seed: int, folder: Path, without: frozenset[int] = frozenset()
) -> "Fleet":
    """The fleet that the marker of a test asks for."""
    from dataclasses import replace  # noqa: PLC0415 - late, by rule 3

    from clew.api.launched import LaunchedFleet, check_speed  # noqa: PLC0415 - late, by rule 3
    from clew.api.rehearsed import RehearsedFleet, asked_of  # noqa: PLC0415 - late, by rule 3

    said = _asked(item)
    asked = asked_of(
        said.get("scenario", "grove"),
        robots=said.get("robots"),
        seed=seed,
        faults=said.get("faults", ()),
        out=folder,
        law=said.get("law"),
        deployment=said.get("deployment"),
        time_s_max=said.get("time_s_max"),
    )
    asked, speed = replace(asked, without=without), said.get("speed", SPEED)
    check_speed(speed)
    return RehearsedFleet(asked) if stage == REHEARSAL else LaunchedFleet(asked, speed)


def _asked(node: pytest.Item) -> dict[str, Any]:
    """What the markers of a test say, the nearest one first."""
    said: dict[str, Any] = {}
    for mark in node.iter_markers(MARK):
        unknown = sorted(set(mark.kwargs) - set(OPTIONS))
        if mark.args or unknown:
            wrong = ", ".join([*map(repr, mark.args), *unknown])
            raise _refusal(node.nodeid, f"@pytest.mark.clew takes {', '.join(OPTIONS)}, not {wrong}")
        said = {**mark.kwargs, **said}
    return said


def _test(item: pytest.Item, name: str, fleet: "Fleet", error: BaseException) -> Any:  # noqa: ANN401 - its type is loaded late
    """The test, to be played again with fewer faults."""
    from clew.api.failing import Test  # noqa: PLC0415 - late, by rule 3

    def play(without: frozenset[int], folder: Path) -> "tuple[Fleet, BaseException | None]":
        again = _made(item, REHEARSAL, fleet.asked.seed, folder, without)
        function = item.obj  # type: ignore[attr-defined] # of every test function
        arguments = {each: item.funcargs[each] for each in signature(function).parameters}  # type: ignore[attr-defined] # of every test function, too
        failed: BaseException | None = None
        try:
            _finished(function(**arguments | {name: again}))
            _check_struck(item, again)
        except (KeyboardInterrupt, SystemExit):
            raise
        except BaseException as raised:  # pytest's own failures are no exceptions
            failed = raised
        finally:
            again.close()
        return again, failed

    seed, stage = fleet.asked.seed, item.config.getoption("--clew-stage")
    replay = ["pytest", item.nodeid, f"--clew-seed={seed}", *([f"--clew-stage={stage}"] if stage else [])]
    return Test(
        path=Path(item.path),
        replay=shlex.join(replay),
        error=error,
        mistake=_mistake(item, error),
        play=None if item.config.getoption("--clew-no-shrink") else play,
    )
