"""A program that is interrupted while it loads its modules ends without a traceback."""

import importlib
import os
import signal
import subprocess
import sys
from pathlib import Path
from threading import Thread

import pytest

from protocol.process.loading import loading
from protocol.root import ROOT
from tests.support.deadline import DEADLINE_S

INTERRUPTED = "import os, signal\nos.kill(os.getpid(), signal.SIGINT)\n"


@pytest.mark.parametrize("program", ["agents", "protocol", "world"])
def test_ctrl_c_while_a_program_loads_ends_it_by_this_signal_without_a_word(
    tmp_path: Path, program: str
) -> None:
    (tmp_path / "argparse.py").write_text(INTERRUPTED)
    path = os.pathsep.join((str(tmp_path), str(ROOT)))
    said = subprocess.run(
        [sys.executable, "-m", program],
        env=os.environ | {"PYTHONPATH": path},
        capture_output=True,
        timeout=DEADLINE_S,
        check=False,
    )
    assert (said.returncode, said.stdout, said.stderr) == (-signal.SIGINT, b"", b"")


def test_afterwards_ctrl_c_raises_again_even_if_loading_failed() -> None:
    with pytest.raises(ModuleNotFoundError), loading():
        importlib.import_module("no_such_module_of_ours")
    assert signal.getsignal(signal.SIGINT) is signal.default_int_handler


def test_what_a_program_ignores_it_still_ignores() -> None:
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    try:
        with loading():
            assert signal.getsignal(signal.SIGINT) is signal.SIG_IGN
    finally:
        signal.signal(signal.SIGINT, signal.default_int_handler)


def test_a_thread_that_loads_leaves_signals_alone() -> None:
    seen = []

    def load() -> None:
        with loading():
            seen.append(signal.getsignal(signal.SIGINT))

    thread = Thread(target=load)
    thread.start()
    thread.join(DEADLINE_S)
    assert seen == [signal.default_int_handler]
