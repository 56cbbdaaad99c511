"""`python -m protocol`: the fleet's router."""

import argparse
import os
import selectors
import signal
import socket
import sys
from pathlib import Path

import msgspec

from protocol.errors import UsageError
from protocol.router import open_router
from protocol.session import read_router_session

USAGE_EXIT_CODE = 2
INTERRUPTED_EXIT_CODE = 130  # 128 + SIGINT, as shells have it
STDIN = 0


def main() -> int:
    """Run the router until it is told to end; returns the exit code."""
    arguments = _parse()
    asked_to_end = _signals()
    try:
        session = read_router_session(arguments.sessions)
        if arguments.listen is not None:
            session = msgspec.structs.replace(session, endpoint=arguments.listen)
        with open_router(session, arguments.sessions):
            print(f"ready {session.endpoint}", flush=True)  # noqa: T201 - what the launcher waits for
            return _wait(asked_to_end, lifeline=arguments.lifeline)
    except UsageError as error:
        print(f"router: {error}", file=sys.stderr)  # noqa: T201 - the user reads it
        return USAGE_EXIT_CODE


def _parse() -> argparse.Namespace:
    parser = argparse.ArgumentParser(
        prog="python -m protocol",
        description="The fleet's Zenoh router: admits the fleet's processes by their passwords and "
        "passes on what each may say. Prints `ready ENDPOINT` when it listens; ends on SIGTERM or Ctrl-C.",
    )
    parser.add_argument(
        "--sessions", type=Path, required=True, metavar="DIR", help="folder of the run's session files"
    )
    parser.add_argument(
        "-l", "--listen", metavar="ENDPOINT", help="listen here, e.g. tcp/127.0.0.1:7447, not where they say"
    )
    parser.add_argument(
        "--lifeline", action="store_true", help="end when stdin does, so that no launcher leaves us behind"
    )
    return parser.parse_args()


def _signals() -> socket.socket:
    """A socket from which the numbers of SIGTERM and SIGINT can be read; they do nothing else."""
    ours, theirs = socket.socketpair()
    theirs.setblocking(False)
    signal.set_wakeup_fd(theirs.detach())
    for number in (signal.SIGTERM, signal.SIGINT):
        signal.signal(number, lambda *_: None)
    return ours


def _wait(asked_to_end: socket.socket, *, lifeline: bool) -> int:
    with selectors.SelectSelector() as selector:  # epoll refuses a stdin that is a file
        selector.register(asked_to_end, selectors.EVENT_READ)
        if lifeline:
            selector.register(STDIN, selectors.EVENT_READ)
        while True:
            for key, _ in selector.select():
                if key.fileobj is asked_to_end:
                    return INTERRUPTED_EXIT_CODE if asked_to_end.recv(1)[0] == signal.SIGINT else 0
                if not os.read(STDIN, 4096):
                    return 0


if __name__ == "__main__":
    sys.exit(main())
