import re
from datetime import UTC, datetime
from pathlib import Path

import pytest

from clew.fleet.folder import LATEST, drop_folder, folder_name, make_folder, make_latest
from clew.fleet.prepare import Prepared, Shows, prepare, run_name, shows
from protocol.errors import UsageError
from protocol.faults.plan import load as load_plan
from protocol.network.session import read_session
from protocol.run_settings import Settings, read_plan, read_settings
from tests.support.campaigns import clew
from tests.support.verbs import asked
from world.record.run_files import read_scenario
from world.scenario.reading import SCENARIOS
from world.scenario.scenario import load

NOON = datetime(2026, 11, 20, 12, 0, 0, tzinfo=UTC)


@pytest.fixture
def private(tmp_path: Path) -> Path:
    folder = tmp_path / "private"
    folder.mkdir()
    return folder


@pytest.fixture(autouse=True)
def somewhere_else(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A separate working folder, so that tests write nothing into the project's `runs/`."""
    folder = tmp_path / "cwd"
    folder.mkdir()
    monkeypatch.chdir(folder)
    return folder


def made(private: Path, *arguments: str) -> Prepared:
    return prepare(asked(*arguments), private, terminal=False)


def test_default_is_grove_in_real_time_with_seed_1() -> None:
    request = asked()
    assert (request.scenario, request.robots, request.seed, request.speed) == ("grove", None, 1, 1.0)


def test_the_resolved_request_is_written_into_the_runs_folder(private: Path, tmp_path: Path) -> None:
    own = tmp_path / "own.toml"
    own.write_bytes((SCENARIOS / "grove.toml").read_bytes())
    words = [
        str(own),
        "-n",
        "3",
        "--seed",
        "7",
        "--law",
        "resultant",
        "--speed",
        "max",
        "--faults",
        "loss-50",
    ]
    run = tmp_path / "run"
    made(private, *words, "--out", str(run))
    own.unlink()
    assert read_scenario(run) == load("grove", robots=3, law="resultant", seed=7)
    assert read_settings(run) == Settings(seed=7, speed=None)
    assert read_plan(run) == load_plan("loss-50")


@pytest.mark.parametrize(
    ("arguments", "kept", "bytes_max"),
    [((), True, 256 << 20), (("--keep", "2.5"), True, 5 << 19), (("--keep", "0"), False, None)],
)
def test_robots_keep_as_much_of_their_inputs_as_was_asked(
    private: Path, arguments: tuple[str, ...], kept: bool, bytes_max: int | None
) -> None:
    made(private, *arguments)
    session = read_session(private / "r2.json")
    assert (session.inputs is not None) is kept
    assert bytes_max in {None, session.inputs_bytes_max}


@pytest.mark.parametrize(
    ("arguments", "complaint"),
    [
        (["-n", "0"], "Invalid value for '-n' / '--robots': 0 is not in the range"),
        (["-n", "many"], "'many' is not an integer"),
        (["--seed", "-1"], "Invalid value for '--seed'"),
        (["--speed", "0"], r"must be max or a number in \(0, 1000\], got '0'"),
        (["--speed", "nan"], "got 'nan'"),
        (["--law", "murphy"], "Invalid value for '--law': must be one of .*, got 'murphy'"),
        (["-e", "tcp/a:1", "-l", "tcp/b:1"], "--connect: not allowed with --listen"),
        (["--routers", "2", "-l", "tcp/b:1"], "--routers: .*not allowed with"),
        (["--routers", "3"], "Invalid value for '--routers'"),
        (["--sped", "2"], "No such option.*--speed"),
        (["--law", "certifid"], "certifid.*did you mean 'certified'"),
        (["paper", "grove"], "unexpected extra argument"),
    ],
)
def test_invalid_option_is_refused_by_name(arguments: list[str], complaint: str) -> None:
    said = clew("run", *arguments)
    assert (said.exit_code, said.stdout, said.stderr.count("\n")) == (2, "", 1)
    assert re.search(complaint, said.stderr)


def test_folder_that_is_not_empty_is_refused(private: Path, tmp_path: Path) -> None:
    with pytest.raises(UsageError, match="is not empty"):
        made(private, "--out", str(tmp_path))


def test_of_two_fleets_that_begin_in_one_folder_at_once_the_second_is_refused(tmp_path: Path) -> None:
    folder = tmp_path / "run"
    begun = make_folder(folder)
    before = sorted(folder.iterdir())
    with pytest.raises(UsageError, match="is not empty"):
        make_folder(folder)
    assert (begun, sorted(folder.iterdir())) == ([folder], before)


def test_of_two_fleets_that_have_both_found_the_folder_empty_one_is_refused(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    folder = tmp_path / "run"
    make_folder(folder)
    monkeypatch.setattr(Path, "iterdir", lambda _: iter(()))
    with pytest.raises(UsageError, match="another fleet begins there"):
        make_folder(folder)


def test_good_request_makes_the_folder_and_returns_the_run(private: Path, somewhere_else: Path) -> None:
    run = made(private, "paper", "--out", "it's/here", "--json")
    assert (run.robots, run.own_routers, run.as_json, run.view) == (5, 1, True, False)
    assert (run.shows, run.latest, run.folder) == (Shows.LINES, None, Path("it's/here"))
    assert (somewhere_else / "it's" / "here").is_dir()
    assert run.made == (somewhere_else / "it's" / "here", somewhere_else / "it's")
    assert (private / "r5.json").exists()
    assert (private / "world.json").exists()


def test_our_own_router_requires_passwords(private: Path) -> None:
    assert made(private).own_routers == 1
    assert read_session(private / "r1.json").password


def test_run_without_out_gets_a_new_folder_in_runs(private: Path, somewhere_else: Path) -> None:
    run = made(private)
    (folder,) = (somewhere_else / "runs").iterdir()
    assert re.fullmatch(r"\d{8}T\d{6}Z-grove-[0-9a-f]{4}", folder.name)
    assert (run.folder.name, run.latest) == (folder.name, LATEST)


def test_run_that_never_began_leaves_no_folder_and_no_link(private: Path, somewhere_else: Path) -> None:
    run = made(private)
    make_latest(run.folder)
    drop_folder(run.folder, run.made, run.latest)
    assert list(somewhere_else.iterdir()) == []


def test_run_that_never_began_leaves_earlier_runs_alone(private: Path, somewhere_else: Path) -> None:
    before, run = made(private), made(private)
    make_latest(before.folder)
    drop_folder(run.folder, run.made, run.latest)
    assert sorted((somewhere_else / "runs").iterdir()) == sorted(
        [before.folder.absolute(), LATEST.absolute()]
    )


def test_after_a_run_that_never_began_the_link_is_to_the_newest_run_that_is_left(
    private: Path, somewhere_else: Path
) -> None:
    older, newer = (somewhere_else / "runs" / f"20260101T00000{n}Z-grove-0000" for n in (1, 2))
    for folder in (newer, older, somewhere_else / "runs" / "zoo"):
        folder.mkdir(parents=True)
    run = made(private)
    make_latest(run.folder)
    drop_folder(run.folder, run.made, run.latest)
    assert LATEST.resolve() == newer.resolve()


def test_run_whose_folder_cannot_be_written_leaves_nothing(
    private: Path, somewhere_else: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def full(folder: Path, *_: object) -> None:
        (folder / "scenario.toml").touch()
        raise UsageError("no space left on device")

    monkeypatch.setattr("clew.fleet.prepare.prepare_folder", full)
    with pytest.raises(UsageError, match="no space left"):
        made(private)
    assert list(somewhere_else.iterdir()) == []


def test_folder_with_written_files_stays(private: Path, somewhere_else: Path) -> None:
    run = made(private, "--out", "here/too")
    (run.folder / "events.jsonl").touch()
    drop_folder(run.folder, run.made, run.latest)
    assert (somewhere_else / "here" / "too" / "events.jsonl").exists()


def test_names_sort_by_time_and_fit_into_a_key() -> None:
    assert run_name(NOON, "0a1b") == "20261120T120000Z-0a1b"
    assert folder_name(NOON, "barn 003", "0a1b") == "20261120T120000Z-barn-003-0a1b"
    assert folder_name(NOON, "../../etc: a $(door)", "0a1b") == "20261120T120000Z-etc-a-door-0a1b"
    assert folder_name(NOON, "/", "0a1b") == "20261120T120000Z-scenario-0a1b"
    assert folder_name(NOON, "x" * 200, "0a1b") == f"20261120T120000Z-{'x' * 60}-0a1b"


def test_a_run_is_named_after_its_scenario_and_not_after_the_file(
    private: Path, somewhere_else: Path
) -> None:
    text = (SCENARIOS / "grove.toml").read_text(encoding="utf-8")
    (somewhere_else / "draft-2.toml").write_text(
        text.replace('name = "grove"', 'name = "North yard"'), encoding="utf-8"
    )
    run = made(private, "draft-2.toml")
    assert re.fullmatch(r"\d{8}T\d{6}Z-North-yard-[0-9a-f]{4}", run.folder.name)


@pytest.mark.parametrize(
    ("arguments", "environment", "terminal", "shown"),
    [
        ([], {"TERM": "xterm"}, True, Shows.TABLE),
        ([], {"TERM": "xterm"}, False, Shows.LINES),
        ([], {"TERM": "dumb"}, True, Shows.LINES),
        ([], {}, True, Shows.LINES),
        ([], {"TERM": "xterm", "CI": "true"}, True, Shows.LINES),
        (["--json"], {"TERM": "xterm"}, True, Shows.LINES),
        (["--quiet"], {"TERM": "xterm"}, True, Shows.NOTHING),
        (["--quiet"], {}, False, Shows.NOTHING),
    ],
)
def test_table_is_shown_on_a_terminal_only_and_lines_elsewhere(
    arguments: list[str], environment: dict[str, str], terminal: bool, shown: Shows
) -> None:
    assert shows(asked(*arguments), environment, terminal=terminal) == shown
