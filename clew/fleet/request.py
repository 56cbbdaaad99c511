"""The request on the command line of `launch/fleet.sh`, each value checked by itself."""

import argparse
import re
import sys
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import NoReturn

from clew.fleet.options import DEPLOYMENTS, law_of, seed_of, speed_of, time_of, version
from protocol.errors import UsageError
from protocol.exit_codes import ExitCode
from protocol.files.names import did_you_mean
from protocol.frames import ROBOTS_MAX
from protocol.laws import OURS
from protocol.network.session import ROUTERS_MAX


@dataclass(frozen=True, slots=True, kw_only=True)
class Request:
    """A request from the command line, each value checked by itself."""

    scenario: str
    robots: int | None
    seed: int
    law: str | None
    deployment: str | None
    time_s_max: float | None
    speed: float | None
    """Times real time; None: as fast as the robots answer."""
    faults: str | None
    out: Path | None
    as_json: bool
    quiet: bool
    view: bool
    routers: int
    connect: str | None
    listen: str | None


class _Parser(argparse.ArgumentParser):
    def error(self, message: str) -> NoReturn:
        raise UsageError(message)

    def parse_all(self, arguments: Sequence[str]) -> argparse.Namespace:
        """The arguments, parsed; the refusal of an unknown option suggests the nearest one."""
        said, unknown = self.parse_known_args(arguments)
        if unknown:
            near = did_you_mean(unknown[0].partition("=")[0], self._option_string_actions)
            self.error(f"unrecognized arguments: {' '.join(unknown)}{near}")
        return said


class _Version(argparse.Action):
    def __call__(self, *_: object) -> NoReturn:
        sys.stdout.write(f"{version()}\n")
        sys.exit(ExitCode.OK)


def parse(arguments: Sequence[str]) -> Request:
    """The request on a command line.

    Raises:
        UsageError: it is no valid request.
    """
    parser = _Parser(
        prog="fleet.sh",
        description="Run a fleet as real processes: a router, a world and one process per robot. "
        "Progress goes to stderr: a live table on a terminal, otherwise one line per event. "
        "The last line on stdout is the verdict and the run's folder.",
        epilog="Exit code: 0 all promises kept, 1 the run failed or broke a promise, 2 cannot run as asked, "
        "130 Ctrl-C, 143 SIGTERM, 129 SIGHUP, 128+n the world died of signal n.",
        allow_abbrev=False,
    )
    parser.add_argument(
        "--version", action=_Version, nargs=0, default=argparse.SUPPRESS, help="show the version and exit"
    )
    _add_what_is_run(parser)
    _add_where_and_how(parser)
    request = Request(**vars(parser.parse_all(arguments)))
    if request.routers > 1 and (request.connect or request.listen):
        parser.error("argument --routers: two have private sockets, not allowed with --connect or --listen")
    return request


def _add_what_is_run(parser: argparse.ArgumentParser) -> None:
    parser.add_argument(
        "scenario",
        nargs="?",
        default="grove",
        metavar="SCENARIO",
        help="a name in launch/scenarios/, a TOML file or a scene (JSON); default: %(default)s",
    )
    parser.add_argument("-n", "--robots", type=_count, metavar="N", help="robots, instead of the scenario's")
    parser.add_argument(
        "--seed", type=seed_of, default=1, help="decides every random draw; default: %(default)s"
    )
    parser.add_argument(
        "--law",
        type=law_of,
        metavar="LAW",
        help=f"{', '.join(OURS)}, or an installed one, instead of the scenario's",
    )
    _add_word(parser, "--deployment", DEPLOYMENTS, "free places drawn by the seed, instead of the scenario's")
    parser.add_argument(
        "--time-s-max",
        type=time_of,
        metavar="SECONDS",
        help="simulated time after which the run fails, instead of the scenario's",
    )
    parser.add_argument("--speed", type=speed_of, default=1.0, help="times real time, or max; default: 1")
    parser.add_argument(
        "--faults",
        metavar="PLAN",
        help="a name in launch/faults/, or a TOML file: the faults to inject",
    )


def _add_word(parser: argparse.ArgumentParser, option: str, words: Sequence[str], said: str) -> None:
    def word(text: str) -> str:
        if text not in words:
            near = did_you_mean(text, words)
            raise argparse.ArgumentTypeError(f"must be one of {', '.join(words)}, got {text}{near}")
        return text

    parser.add_argument(option, type=word, metavar=f"{{{','.join(words)}}}", help=said)


def _add_where_and_how(parser: argparse.ArgumentParser) -> None:
    parser.add_argument(
        "--out", type=Path, metavar="DIR", help="the run's folder; default: a new one in runs/"
    )
    parser.add_argument(
        "--json", action="store_true", dest="as_json", help="print verdict.json and nothing else"
    )
    parser.add_argument("--quiet", action="store_true", help="print nothing before the run has ended")
    parser.add_argument(
        "--view", action="store_true", help="serve the run's live page on loopback during the run"
    )
    router = parser.add_mutually_exclusive_group()
    router.add_argument(
        "-e",
        "--connect",
        type=_endpoint,
        metavar="ENDPOINT",
        help="use the Zenoh router at this endpoint, start none",
    )
    router.add_argument(
        "-l",
        "--listen",
        type=_endpoint,
        metavar="ENDPOINT",
        help="the endpoint of our router; default: a private socket",
    )
    parser.add_argument(
        "--routers",
        type=int,
        choices=range(1, ROUTERS_MAX + 1),
        default=1,
        help="with 2, one takes over when the other dies; default: %(default)s",
    )


def _count(text: str) -> int:
    if not text.isdecimal() or not 1 <= int(text) <= ROBOTS_MAX:
        raise argparse.ArgumentTypeError(f"must be a whole number from 1 to {ROBOTS_MAX}, got {text}")
    return int(text)


def _endpoint(text: str) -> str:
    if not re.fullmatch(r"[a-z-]+/\S+", text):
        raise argparse.ArgumentTypeError(f"must be PROTOCOL/ADDRESS as in tcp/127.0.0.1:7447, got {text}")
    return text
