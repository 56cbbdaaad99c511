"""`python -m world`: the bodies, sensors, judgement and record of one run."""

import argparse
import logging
import math
import sys
from pathlib import Path

from protocol.errors import UsageError
from protocol.exit_codes import ExitCode
from protocol.mission import Law
from protocol.session import read_session
from world.recorder import RecordingFailedError
from world.scenario import load
from world.shell import Order, run

STDIN = 0


def main() -> int:
    """Run the world; returns the verdict's exit code."""
    arguments = _parse()
    logging.basicConfig(format="world: %(message)s", level=logging.INFO)
    try:
        order = Order(
            scenario=load(arguments.scenario, robots=arguments.robots, law=arguments.law),
            session=read_session(arguments.session),
            out=arguments.out,
            seed=arguments.seed,
            speed=arguments.speed,
            lifeline=STDIN if arguments.lifeline else None,
        )
        verdict = run(order)
    except UsageError as error:
        logging.error("%s", error)
        return ExitCode.USAGE
    except RecordingFailedError as error:
        logging.error("%s", error)
        return ExitCode.FAILED
    logging.info("%s: %s", "ok" if verdict.ok else "FAILED", verdict.reason)
    return verdict.exit_code


def _parse() -> argparse.Namespace:
    parser = argparse.ArgumentParser(
        prog="python -m world",
        description="The world of one run: gives robots bodies and sensors, judges what they do, and "
        "writes events.jsonl and verdict.json. Exits with the verdict: 0 kept its promises, 1 failed, "
        "2 wrong usage, 130 interrupted, 143 told to end.",
    )
    parser.add_argument("scenario", help="a name in launch/scenarios, a .toml or a clew-scene/1 .json file")
    parser.add_argument(
        "--session", type=Path, required=True, metavar="FILE", help="the world's session file"
    )
    parser.add_argument("--out", type=Path, required=True, metavar="DIR", help="the run's folder")
    parser.add_argument("-n", "--robots", type=int, metavar="N", help="how many robots, not the scenario's")
    parser.add_argument("--seed", type=seed_of, default=1, metavar="S", help="decides all noise; default 1")
    parser.add_argument("--law", choices=[law.value for law in Law], help="the law, not the scenario's")
    parser.add_argument(
        "--speed", type=speed_of, default=1.0, metavar="X|max", help="simulated s per s; max: in lock-step"
    )
    parser.add_argument(
        "--lifeline", action="store_true", help="end when stdin does, so that no launcher leaves us behind"
    )
    return parser.parse_args()


def seed_of(text: str) -> int:
    """The seed that a text says.

    Raises:
        argparse.ArgumentTypeError: it says none.
    """
    if not (text.isascii() and text.isdecimal() and int(text) <= 2**53):  # what JSON readers keep exact
        raise argparse.ArgumentTypeError(f"{text!r} must be a whole number from 0 to 2**53")
    return int(text)


def speed_of(text: str) -> float | None:
    """The speed that a text says; None for `max`.

    Raises:
        argparse.ArgumentTypeError: it says none.
    """
    try:
        speed = None if text == "max" else float(text)
    except ValueError:
        speed = math.nan
    if speed is not None and not 0.0 < speed <= 1000.0:
        raise argparse.ArgumentTypeError(f"{text!r} must be above 0 and at most 1000, or max")
    return speed


if __name__ == "__main__":
    sys.exit(main())
