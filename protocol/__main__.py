"""`python -m protocol`: the fleet's router."""

from protocol.process.loading import loading

with loading():
    import argparse
    import asyncio
    import sys
    from pathlib import Path

    import msgspec

    from protocol.errors import UsageError
    from protocol.exit_codes import ExitCode
    from protocol.network.router import open_router
    from protocol.network.session import ROUTERS_MAX, RouterSession, read_router_session
    from protocol.plain import plain
    from protocol.process.allocation import allocate_from_one_arena
    from protocol.process.ending import until_ended

STDIN = 0


def main() -> int:
    """Run the router until it is asked to end; returns the exit code."""
    arguments = _parse()
    allocate_from_one_arena()
    try:
        session = read_router_session(arguments.sessions)
        if arguments.number > len(session.endpoints):
            raise UsageError(
                f"the sessions are of {len(session.endpoints)} router, not of {arguments.number}"
            )
        if arguments.listen is not None:
            session = _elsewhere(session, arguments.number, arguments.listen)
        listening = _listen(session, arguments.sessions, arguments.number)
        return asyncio.run(until_ended(listening, STDIN if arguments.lifeline else None))
    except UsageError as error:
        print(plain(f"router: {error}"), file=sys.stderr)  # noqa: T201 - the user reads it
        return ExitCode.USAGE


def _parse() -> argparse.Namespace:
    parser = argparse.ArgumentParser(
        prog="python -m protocol",
        description="The fleet's Zenoh router: it admits the fleet's processes by password and forwards the "
        "messages that each may send. Prints `ready ENDPOINT` when it listens; ends on SIGTERM or Ctrl-C.",
    )
    parser.add_argument(
        "--sessions", type=Path, required=True, metavar="DIR", help="folder of the run's session files"
    )
    parser.add_argument(
        "--number",
        type=int,
        choices=range(1, ROUTERS_MAX + 1),
        default=1,
        help="which of the fleet's routers; default: %(default)s",
    )
    parser.add_argument(
        "-l", "--listen", metavar="ENDPOINT", help="listen here instead, e.g. tcp/127.0.0.1:7447"
    )
    parser.add_argument(
        "--lifeline", action="store_true", help="end when stdin ends, so that no router outlives its launcher"
    )
    return parser.parse_args()


def _elsewhere(session: RouterSession, number: int, endpoint: str) -> RouterSession:
    endpoints = [endpoint if at == number else said for at, said in enumerate(session.endpoints, start=1)]
    return msgspec.structs.replace(session, endpoints=tuple(endpoints))


async def _listen(session: RouterSession, folder: Path, number: int) -> int:
    with open_router(session, folder, number):
        print(f"ready {session.endpoints[number - 1]}", flush=True)  # noqa: T201 - what the launcher waits for
        return await asyncio.Event().wait()  # never set: the router runs until it is asked to end


if __name__ == "__main__":
    sys.exit(main())
