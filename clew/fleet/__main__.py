"""`python -m clew.fleet`: runs a fleet as real processes. Users call it through `launch/fleet.sh`.

Rule 1: a request that cannot work ends with one line on stderr and exit code 2, and leaves nothing behind.
Rule 2: a request to end that arrives before the run begins is kept until then. One that arrives after the end
        of the run changes nothing.
Rule 3: slow modules are imported only when they are certainly needed.
"""

import sys
from collections.abc import Callable, Sequence

from clew.fleet.request import parse
from protocol.asked import ignore, listen
from protocol.errors import SessionLostError, UsageError
from protocol.exit_codes import ExitCode
from protocol.plain import plain


class Requests:
    """Collects the requests to end the run, from the first moment on."""

    def __init__(self) -> None:
        self.kept: list[ExitCode] = []
        """The requests that arrived before there was a listener."""
        self._tell: Callable[[ExitCode], None] = self.kept.append

    def note(self, code: ExitCode) -> None:
        """A signal has arrived that asks for this exit code."""
        self._tell(code)

    def hear(self, tell: Callable[[ExitCode], None]) -> None:
        """Pass all requests to this listener, the earlier ones first."""
        self._tell = tell
        for code in self.kept:
            tell(code)


def main(arguments: Sequence[str]) -> int:
    """Run a fleet; returns the exit code."""
    requests = Requests()
    listen(requests.note)
    try:
        # Help is printed regardless of the other arguments.
        request = parse(["--help"] if {"-h", "--help"} & set(arguments) else arguments)
        # It imports numpy and scipy, which neither help nor a refusal needs.
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
