"""`clew report`: a single small file that requests nothing and names the flaws of a log."""

import json
import re
import shutil
import subprocess
from importlib.resources import files
from pathlib import Path

import pytest
from click.testing import CliRunner, Result

from clew.cli import main
from clew.page.document import SCRIPTS, STYLES, document
from protocol.root import ROOT
from tests.support.deadline import DEADLINE_S
from tests.support.pages.pages import inlined
from tests.support.runs import Runs
from world.judge.verdict import VERDICT_FILE
from world.record.recorder import EVENTS_FILE

ASSETS = Path(str(files("clew.page") / "assets"))
FILES = [path for path in ASSETS.rglob("*") if path.is_file()]
BYTES_MAX = 1_000_000  # of a report of ten robots and 60 s
TEN = {"robots = 5": "robots = 10", "x_m_min = 0.0": "x_m_min = -3.0"}
REQUESTS = re.compile(
    r"https?://|\bsrc\s*=|\bhref\s*=|url\(|@import|\bfetch\(|\bimport\b\s*[({'\"]|XMLHttpRequest"
)


def report(*arguments: str | Path) -> Result:
    return CliRunner().invoke(main, ["report", *map(str, arguments)])


@pytest.fixture(scope="module")
def run(runs: Runs) -> Path:
    return runs.of("paper")


@pytest.fixture
def copy(run: Path, tmp_path: Path) -> Path:
    """A copy of a run, to damage."""
    return Path(shutil.copytree(run, tmp_path / "copy"))


def edit(run: Path, *, old: bytes, new: bytes) -> None:
    events = run / EVENTS_FILE
    text = events.read_bytes()
    assert old in text
    events.write_bytes(text.replace(old, new, 1))


def test_the_report_is_written_beside_the_log_and_its_path_is_printed(copy: Path) -> None:
    said = report(copy)
    assert (said.exit_code, said.stdout, said.stderr) == (0, f"{copy / 'report.html'}\n", "")
    [batch] = inlined((copy / "report.html").read_text(encoding="utf-8"))
    assert batch["verdict"] == json.loads((copy / VERDICT_FILE).read_bytes())
    assert "flaws" not in batch


def test_the_report_is_written_to_the_given_path_with_its_folders(copy: Path, tmp_path: Path) -> None:
    path = tmp_path / "new" / "folder" / "why.html"
    assert report(copy / EVENTS_FILE, "--out", path).stdout == f"{path}\n"
    assert path.is_file()
    assert not (copy / "report.html").exists()


def test_the_page_requests_nothing_and_cannot(copy: Path) -> None:
    report(copy)
    page = (copy / "report.html").read_text(encoding="utf-8")
    without_story = re.sub(r'(id="story">)[^<]*', r"\1", page)
    assert REQUESTS.findall(without_story) == []
    assert "default-src 'none'" in page
    assert "connect-src 'none'" in page


def test_ten_robots_take_less_than_a_megabyte_per_minute(runs: Runs, tmp_path: Path) -> None:
    scenario = (ROOT / "launch" / "scenarios" / "grove.toml").read_text(encoding="utf-8")
    for old, new in TEN.items():
        assert old in scenario
        scenario = scenario.replace(old, new)
    (tmp_path / "ten.toml").write_text(scenario, encoding="utf-8")
    run = runs.copy(tmp_path / "run", str(tmp_path / "ten.toml"))
    report(run)
    page = run / "report.html"
    [batch] = inlined(page.read_text(encoding="utf-8"))
    empty = len(document())
    assert empty + (page.stat().st_size - empty) * 60.0 / batch["end_s"] < BYTES_MAX


def flaws_of(run: Path) -> tuple[Result, list[str]]:
    """The verb's messages on a damaged run, and the flaws in its page."""
    said = report(run)
    batches = inlined((run / "report.html").read_text(encoding="utf-8"))
    return said, batches[-1]["flaws"]


@pytest.mark.parametrize(
    ("old", "new", "flaw"),
    [
        (b'"kind":"run.ended"', b'"kind":"run.e', "cannot be read"),
        (b'"clew-timeline/1"', b'"clew-timeline/2"', "only what both know is shown"),
        (b'"kind":"goal.reached"', b'"kind":"goal.moved"', "does not know: 'goal.moved'"),
        (b'"robot":1,', b'"robot":"one",', "cannot be read"),
        (b'"epsilon_m":', b'"epsilon_furlongs":', "no distances: the scenario in the header cannot be read"),
    ],
)
def test_flaws_of_a_log_are_named_and_the_rest_is_shown(
    copy: Path, old: bytes, new: bytes, flaw: str
) -> None:
    edit(copy, old=old, new=new)
    said, flaws = flaws_of(copy)
    assert said.exit_code == 0
    assert any(flaw in each for each in flaws)
    assert said.stderr.splitlines() == [f"not complete: {each}" for each in flaws]
    [batch] = inlined((copy / "report.html").read_text(encoding="utf-8"))
    assert len(batch["tracks"]) == 5
    assert batch["verdict"]["ok"]


def test_a_torn_last_line_is_named_and_the_rest_is_shown(copy: Path) -> None:
    events = copy / EVENTS_FILE
    events.write_bytes(events.read_bytes()[:-20])
    said, flaws = flaws_of(copy)
    assert said.exit_code == 0
    assert any("is torn: dropped" in each for each in flaws)


def test_a_run_without_a_verdict_is_shown_with_a_remark(copy: Path) -> None:
    (copy / VERDICT_FILE).unlink()
    said, flaws = flaws_of(copy)
    assert (said.exit_code, flaws) == (0, [f"there is no {VERDICT_FILE}"])


def test_an_unreadable_verdict_is_named_and_the_run_is_shown(copy: Path) -> None:
    (copy / VERDICT_FILE).write_text("{", encoding="utf-8")
    said, flaws = flaws_of(copy)
    assert said.exit_code == 0
    assert flaws[0].startswith(f"{VERDICT_FILE} cannot be read")


@pytest.mark.parametrize("text", [None, b"", b"no header\n"])
def test_a_folder_that_is_no_run_is_refused_in_one_line_and_left_unchanged(
    tmp_path: Path, text: bytes | None
) -> None:
    if text is not None:
        (tmp_path / EVENTS_FILE).write_bytes(text)
    before = list(tmp_path.iterdir())
    said = report(tmp_path)
    assert (said.exit_code, said.stdout, said.stderr.count("\n")) == (2, "", 1)
    assert str(tmp_path) in said.stderr
    assert list(tmp_path.iterdir()) == before


def test_a_missing_run_makes_no_page(tmp_path: Path) -> None:
    said = report(tmp_path / "nowhere")
    assert said.exit_code == 2
    assert "no run in" in said.stderr
    assert list(tmp_path.iterdir()) == []


def test_a_page_that_cannot_be_written_is_refused(copy: Path, tmp_path: Path) -> None:
    (tmp_path / "file").touch()
    said = report(copy, "--out", tmp_path / "file" / "page.html")
    assert said.exit_code == 2
    assert "cannot write" in said.stderr


@pytest.mark.parametrize("name", [EVENTS_FILE, VERDICT_FILE])
def test_only_a_report_is_ever_replaced(copy: Path, name: str) -> None:
    before = (copy / name).read_bytes()
    said = report(copy, "--out", copy / name)
    assert (said.exit_code, said.stdout) == (2, "")
    assert "bears no mark of Clew" in said.stderr
    assert (copy / name).read_bytes() == before


def test_a_report_is_replaced_by_a_newer_one_but_never_by_an_error_page(copy: Path) -> None:
    assert [report(copy).exit_code, report(copy).exit_code] == [0, 0]
    before = (copy / "report.html").read_bytes()
    (copy / "broken").mkdir()
    for bad, out in ((copy / VERDICT_FILE, ()), (copy / "broken", ("--out", copy / "report.html"))):
        said = report(bad, *out)
        assert said.exit_code == 2
        assert (copy / "report.html").read_bytes() == before


def test_a_file_that_is_no_log_makes_no_page(copy: Path) -> None:
    assert report(copy / VERDICT_FILE).exit_code == 2
    assert not (copy / "report.html").exists()


def test_all_assets_are_in_the_page_and_small() -> None:
    assert {path.relative_to(ASSETS).as_posix() for path in FILES} == {*SCRIPTS, *STYLES, "index.html"}
    assert max(len(path.read_text(encoding="utf-8").splitlines()) for path in FILES) <= 200


@pytest.mark.skipif(shutil.which("node") is None, reason="node, which checks the syntax, is not here")
def test_scripts_are_correct_javascript() -> None:
    """In one process for all: a script that is not correct is named in what it says."""
    each = "new (require('vm').Script)(require('fs').readFileSync(name, 'utf8'), { filename: name })"
    compile_all = f"for (const name of process.argv.slice(1)) {each}"
    said = subprocess.run(
        ["node", "--eval", compile_all, *(ASSETS / name for name in SCRIPTS)],
        timeout=DEADLINE_S,
        check=False,
        capture_output=True,
    )
    assert said.returncode == 0, said.stderr.decode()
