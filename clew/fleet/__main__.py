"""`python -m clew.fleet`: runs a fleet as real processes; `launch/fleet.sh` is how users call it.

Rule 1: what cannot work is one line on stderr and exit code 2, and leaves nothing behind.
Rule 2: a request to end that comes before the run could begin is kept until then. One that comes when the run
        has ended changes nothing.
Rule 3: what takes long to load is loaded when it is certain that it is needed.
"""

import sys
from collections.abc import Callable, Sequence

from clew.fleet.request import parse
from protocol.asked import ignore, listen
from protocol.errors import SessionLostError, UsageError
from protocol.exit_codes import ExitCode
from protocol.plain import plain


class Requests:
    """What asks for the end of the run, from the first moment on."""

    def __init__(self) -> None:
        self.kept: list[ExitCode] = []
        """What has come before anybody heard."""
        self._tell: Callable[[ExitCode], None] = self.kept.append

    def note(self, code: ExitCode) -> None:
        """A signal has come that wants this exit code."""
        self._tell(code)

    def hear(self, tell: Callable[[ExitCode], None]) -> None:
        """Tell this of all requests, of those that have come first."""
        self._tell = tell
        for code in self.kept:
            tell(code)


def main(arguments: Sequence[str]) -> int:
    """Run a fleet; returns the exit code."""
    requests = Requests()
    listen(requests.note)
    try:
        # Help is given whatever else stands there.
        request = parse(["--help"] if {"-h", "--help"} & set(arguments) else arguments)
        # numpy and scipy come with it, which neither help nor a refusal needs.
        from clew.fleet.shell import run_fleet  # noqa: PLC0415 - half a second, as said above

        code = run_fleet(request, requests.hear)
    except UsageError as error:
        code = _refuse(error, ExitCode.USAGE)
    except SessionLostError as error:
        code = _refuse(error, ExitCode.FAILED)
    ignore()
    return code


def _refuse(error: Exception, code: ExitCode) -> int:
    sys.stderr.write(f"fleet.sh: {plain(str(error))}\n")
    return code


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
