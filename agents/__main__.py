"""`python -m agents`: one robot, or a host of several."""

from protocol.process.loading import loading

with loading():
    import argparse
    import sys
    from pathlib import Path

    from agents.process.host import Crew, Orders, run_host, run_robot, say
    from protocol.errors import UsageError
    from protocol.exit_codes import ExitCode
    from protocol.faults.plan import NO_FAULTS
    from protocol.frames import ROBOTS_MAX
    from protocol.law_files import look_in
    from protocol.network.faulty_transport import Conditions
    from protocol.run_settings import read_plan, read_settings

STDIN = 0


def main() -> int:
    """Run the robots; returns the exit code."""
    arguments = _parse()
    lifeline = STDIN if arguments.lifeline else None
    try:
        crews = _crews(arguments)
    except UsageError as error:
        say(f"robots: {error}")
        return ExitCode.USAGE
    [(robots, told), *others] = crews
    if len(robots) == 1 and not others and not arguments.host:
        return run_robot(robots[0], told, lifeline)
    return run_host(crews, lifeline)


def _crews(arguments: argparse.Namespace) -> list[Crew]:
    """The robots of each fleet.

    Raises:
        UsageError: a run's folder is unusable, or a fleet lacks an option that others have.
    """
    runs = arguments.run or [None] * len(arguments.sessions)
    if not len(arguments.robots) == len(arguments.sessions) == len(runs):
        raise UsageError("--robots, --sessions and --run: each fleet has one of each")
    several = len(runs) > 1
    return [
        (robots, Orders(sessions, _conditions(run), fleet=sessions.name if several else ""))
        for robots, sessions, run in zip(arguments.robots, arguments.sessions, runs, strict=True)
    ]


def _conditions(run: Path | None) -> Conditions:
    """The fault plan, seed and pace of the run, whose folder may have its law; no faults without it."""
    if run is None:
        return Conditions(NO_FAULTS, 1, 1.0)
    look_in(run)
    settings = read_settings(run)
    return Conditions(read_plan(run), settings.seed, settings.speed or 1.0)


def robots_of(text: str) -> list[int]:
    """The robots in a text like `3`, `1-5` or `1-3,7`.

    Raises:
        argparse.ArgumentTypeError: the text names no robot, or one twice.
    """
    robots: list[int] = []
    for part in text.split(","):
        first, to, last = part.partition("-")
        last = last if to else first
        if not (first.isascii() and first.isdecimal() and last.isascii() and last.isdecimal()):
            raise argparse.ArgumentTypeError(f"{text!r} is no list of robots such as 3, 1-5 or 1-3,7")
        if not 1 <= int(first) <= int(last) <= ROBOTS_MAX:
            raise argparse.ArgumentTypeError(
                f"{part!r} must name robots from 1 to {ROBOTS_MAX}, lowest first"
            )
        robots.extend(range(int(first), int(last) + 1))
    if len(set(robots)) < len(robots):
        raise argparse.ArgumentTypeError(f"{text!r} must name each robot once")
    return robots


def _parse() -> argparse.Namespace:
    parser = argparse.ArgumentParser(
        prog="python -m agents",
        description="Runs robots; each is a process with its own Zenoh session. Several are forked and "
        "reaped by this process. Exits 0 when one of each fleet ended well, since the run is over; else with "
        "the code of the first that did not: 1, or 2 on wrong usage.",
    )
    parser.add_argument(
        "--robots",
        type=robots_of,
        required=True,
        action="append",
        metavar="LIST",
        help="3, 1-5 or 1-3,7; of several fleets, one list for each, as with --sessions and --run",
    )
    parser.add_argument(
        "--sessions",
        type=Path,
        required=True,
        action="append",
        metavar="DIR",
        help="folder of the fleet's session files",
    )
    parser.add_argument(
        "--host", action="store_true", help="fork even a single robot, so that it can have process faults"
    )
    parser.add_argument(
        "--run",
        type=Path,
        action="append",
        metavar="DIR",
        help="the run's folder, if it exists here: law, fault plan and pace",
    )
    parser.add_argument(
        "--lifeline", action="store_true", help="end when stdin does, so that no launcher leaves us behind"
    )
    return parser.parse_args()


if __name__ == "__main__":
    sys.exit(main())
