"""The set-up: which needs an environment meets, where it is made, and that others are left alone."""

import os
import re
import shlex
import shutil
import signal
import subprocess
import sys
from pathlib import Path

import pytest

from protocol.root import ROOT
from tests.support.deadline import DEADLINE_S

LEVELS = ("run", "tools", "dev")

# Nothing is downloaded here: a link to our own Python replaces an environment with all packages.
LINK = f'mkdir -p "$clew_venv/bin" && ln -sfn {shlex.quote(sys.executable)} "$python"'
INSTALL = f"clew_install() {{ {LINK} && echo installed $1; }}"


def bash(script: str, root: Path = ROOT, **variables: str) -> subprocess.CompletedProcess[str]:
    """Run a script that sources the set-up of a checkout, without the variables of the tests' environment."""
    others = {name: value for name, value in os.environ.items() if name != "CLEW_VENV"}
    return subprocess.run(
        ["bash", "-c", f"source {shlex.quote(str(root))}/launch/setup.sh; {script}"],
        cwd=root.parent,
        env={**others, **variables},
        capture_output=True,
        text=True,
        timeout=DEADLINE_S,
        check=False,
    )


@pytest.fixture
def checkout(tmp_path: Path) -> Path:
    """A folder with the files that the set-up reads; its path has a space."""
    root = tmp_path / "check out"
    root.mkdir()
    shutil.copytree(ROOT / "launch", root / "launch")
    for name in ("pyproject.toml", "requirements.lock"):
        shutil.copy(ROOT / name, root)
    return root


def installed(said: subprocess.CompletedProcess[str]) -> list[str]:
    """The installed sets, in order."""
    return [line.split()[1] for line in said.stderr.splitlines() if line.startswith("installed ")]


def contents(folder: Path) -> set[Path]:
    return set(folder.rglob("*"))


@pytest.mark.parametrize("made_for", LEVELS)
def test_an_environment_also_meets_smaller_needs(made_for: str) -> None:
    asks = "; ".join(f"clew_holds {made_for} {each} && echo {each}" for each in LEVELS)
    assert bash(asks).stdout.split() == list(LEVELS[: LEVELS.index(made_for) + 1])


@pytest.mark.parametrize("changed", ["pyproject.toml", "requirements.lock"])
def test_it_installs_again_only_for_larger_needs_or_a_changed_lock(changed: str, checkout: Path) -> None:
    change = f'echo >>"$clew_root/{changed}"'
    said = bash(
        f"{INSTALL}; for each in run run tools run; do set_up $each; done; {change}; set_up run", checkout
    )
    assert said.returncode == 0
    assert installed(said) == ["run", "tools", "tools"]


def test_two_concurrent_set_ups_install_once(checkout: Path) -> None:
    free = 'flock --nonblock "$clew_venv" echo installed unlocked'
    install = f"clew_install() {{ {LINK} && echo installed $1; ! {free}; }}"
    said = bash(f"{install}; set_up run & set_up run & wait; clew_is_ready run && echo ready", checkout)
    assert installed(said) == ["run"]
    assert said.stdout == "ready\n"


def test_a_foreign_environment_is_refused_and_left_alone(checkout: Path) -> None:
    theirs = checkout / ".venv" / "bin" / "python"
    theirs.parent.mkdir(parents=True)
    theirs.write_text("theirs")
    said = bash(f"{INSTALL}; set_up run; echo never", checkout)
    assert (said.returncode, said.stdout) == (2, "")
    assert said.stderr == (
        f"clew: {checkout}/.venv was not made by Clew: remove it, or name another place in CLEW_VENV\n"
    )
    assert contents(checkout / ".venv") == {theirs.parent, theirs}
    assert theirs.read_text() == "theirs"


def test_with_clew_venv_nothing_is_written_into_the_checkout(checkout: Path) -> None:
    before = contents(checkout)
    said = bash(
        f"{INSTALL}; set_up run; cd /; set_up run; echo $python", checkout, CLEW_VENV="another place/env"
    )
    environment = checkout.parent / "another place" / "env"
    assert installed(said) == ["run"]
    assert said.stdout == f"{environment}/bin/python\n"
    assert (environment / "clew.stamp").exists()
    assert contents(checkout) == before


def test_an_incomplete_environment_is_made_again(checkout: Path) -> None:
    said = bash('clew_install() { touch "$clew_venv/half"; false; }; set_up run', checkout)
    assert (said.returncode, (checkout / ".venv" / "half").exists()) == (2, True)
    assert installed(bash(f"{INSTALL}; set_up run", checkout)) == ["run"]
    assert not (checkout / ".venv" / "half").exists()


def test_a_working_environment_is_kept_during_its_update(checkout: Path) -> None:
    assert installed(bash(f"{INSTALL}; set_up tools", checkout)) == ["tools"]
    (checkout / ".venv" / "in use").touch()
    (checkout / "requirements.lock").write_text("# newer\n")
    assert installed(bash(f"{INSTALL}; set_up run", checkout)) == ["tools"]
    assert (checkout / ".venv" / "in use").exists()


def test_a_working_environment_is_extended_with_its_own_python(checkout: Path) -> None:
    """A `venv` of another Python fails in it, as after `conda activate`."""
    other = checkout / "other" / "python3"
    other.parent.mkdir()
    other.write_text(f'#!/bin/sh\nexec {shlex.quote(sys.executable)} "$@"\n')
    other.chmod(0o755)
    install = f'clew_install() {{ {LINK} && echo "$2" >&2; }}'
    found, kept = (
        bash(f"{install}; set_up {each}", checkout, PATH=path)
        for each, path in (("run", os.environ["PATH"]), ("tools", f"{other.parent}:{os.environ['PATH']}"))
    )
    assert (found.returncode, kept.returncode) == (0, 0)
    assert str(other) not in kept.stderr


def test_an_environment_that_cannot_be_made_is_refused_in_one_line(checkout: Path) -> None:
    place = checkout / "pyproject.toml" / "env"
    said = bash(f"{INSTALL}; set_up run", checkout, CLEW_VENV=str(place))
    assert (said.returncode, said.stdout) == (2, "")
    assert said.stderr == f"clew: {place} cannot be made: CLEW_VENV names another place for it\n"


@pytest.mark.parametrize(
    ("words", "level"),
    [
        (("log", "export", "a", "--to", "csv"), "tools"),
        (("log", "export", "--to=csv", "b"), "run"),
        (("figures", "a"), "tools"),
        (("figures", "--json", "a/events.jsonl"), "tools"),
        (("figures", "b"), "run"),
        (("figures", "none"), "run"),
        (("map", "a/events.jsonl"), "tools"),
        (("log", "export", "--help"), "run"),
        (("figures", "-h"), "run"),
        (("log", "info", "run"), "run"),
        ((), "run"),
    ],
)
def test_more_libraries_come_for_a_verb_with_something_to_read_and_not_for_its_help(
    tmp_path: Path, words: tuple[str, ...], level: str
) -> None:
    for name in ("a", "b"):
        (tmp_path / name).mkdir()
    (tmp_path / "a" / "events.jsonl").touch()
    shutil.copy(ROOT / "launch" / "clew", tmp_path)
    (tmp_path / "setup.sh").write_text('set_up() { echo "$1"; exit; }')
    command: list[str | Path] = [tmp_path / "clew", *words]
    said = subprocess.check_output(command, cwd=tmp_path, text=True, timeout=DEADLINE_S)
    assert said == f"{level}\n"


def test_a_set_up_says_how_far_it_has_come(checkout: Path) -> None:
    """In place of pip there is a script that prints what pip prints."""
    pip = (
        "echo Looking in indexes: x; for i in {1..12}; do echo Collecting it; echo '  Downloading it'; done; "
        "for i in {1..9}; do echo Processing /x/it.whl; done; echo Installing collected packages: a, b"
    )
    fake = f"""python() {{ {pip}; return $FAILS; }}; python=python; clew_pip 21 --requirement x"""
    said = bash(fake, checkout, FAILS="0")
    assert (said.returncode, said.stdout) == (0, "")
    assert said.stderr.splitlines() == [
        "clew: 10 of 21 packages fetched",
        "clew: 20 of 21 packages fetched",
        "clew: all 21 packages fetched; unpacking them",
    ]
    assert bash(fake, checkout, FAILS="3").returncode == 3


def test_a_set_up_says_when_it_begins_and_when_it_is_ready(checkout: Path) -> None:
    lines = bash(f"{INSTALL}; set_up run", checkout).stderr.splitlines()
    assert re.fullmatch(r"clew: setting up .* with Python \S+ \(once; a minute or two\)", lines[0])
    assert re.fullmatch(r"clew: .*/\.venv is ready, after \d+ s", lines[-1])


def test_a_set_up_says_what_it_does_to_an_environment_that_works(checkout: Path) -> None:
    change = 'echo >>"$clew_root/requirements.lock"'
    said = bash(f"{INSTALL}; set_up run; set_up tools; {change}; set_up run; set_up dev", checkout).stderr
    told = [line.split(" with Python")[0] for line in said.splitlines() if "with Python" in line]
    venv = checkout / ".venv"
    assert told == [
        f"clew: setting up {venv}",
        f"clew: adding the libraries for figures, exports and maps to {venv}",
        f"clew: bringing {venv} up to date",
        f"clew: adding the libraries for tests to {venv}",
    ]


@pytest.mark.parametrize(("number", "code"), [("HUP", -1), ("INT", 130), ("TERM", -15)])
def test_a_signal_ends_a_set_up_and_all_that_it_has_started_in_one_line(
    checkout: Path, number: str, code: int
) -> None:
    """The install is Python: it would print a traceback of its own at Ctrl-C, and so would its children."""
    child = "import signal, sys; print('begun', file=sys.stderr, flush=True); signal.pause()"
    parent = f"import subprocess, sys; subprocess.run([sys.executable, '-c', {child!r}])"
    script = f"clew_install() {{ {LINK} && {shlex.quote(sys.executable)} -c {shlex.quote(parent)}; }}"
    with subprocess.Popen(
        ["bash", "-c", f"source {shlex.quote(str(checkout))}/launch/setup.sh; {script}; set_up run; echo on"],
        env={name: value for name, value in os.environ.items() if name != "CLEW_VENV"},
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
        start_new_session=True,
    ) as setting_up:
        assert setting_up.stderr is not None
        while setting_up.stderr.readline() != "begun\n":
            pass
        os.killpg(setting_up.pid, getattr(signal, f"SIG{number}"))  # as a terminal does
        out, err = setting_up.communicate(timeout=DEADLINE_S)
    assert (setting_up.returncode, out) == (code, "")
    assert err == f"clew: setting up {checkout}/.venv was interrupted; nothing of it will be used\n"
