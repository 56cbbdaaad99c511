"""`python -m world`: the bodies, sensors, judgement and timeline of one run."""

import argparse
import logging
import os
import resource
import sys
from pathlib import Path

from protocol.errors import SessionLostError, UsageError
from protocol.exit_codes import ExitCode
from protocol.network.session import read_session
from protocol.plain import PlainFormatter
from protocol.run_settings import check_is_run, read_plan, read_settings
from world.record.recorder import RecordingFailedError
from world.record.run_files import read_scenario
from world.shell import Request, run

STDIN = 0


def main() -> int:
    """Run the world; returns the verdict's exit code."""
    arguments = _parse()
    stderr = logging.StreamHandler()
    stderr.setFormatter(PlainFormatter("world: %(message)s"))
    logging.basicConfig(handlers=[stderr], level=logging.INFO)
    try:
        check_is_run(arguments.run)
        settings = read_settings(arguments.run)
        request = Request(
            scenario=read_scenario(arguments.run),
            session=read_session(arguments.session),
            out=arguments.run,
            seed=settings.seed,
            speed=settings.speed,
            held=settings.held,
            lifeline=STDIN if arguments.lifeline else None,
            plan=read_plan(arguments.run),
            private=arguments.session.parent,
            resume=arguments.resume,
        )
        verdict = run(request)
    except UsageError as error:
        logging.error("%s", error)
        return ExitCode.USAGE
    except RecordingFailedError as error:
        logging.error("%s", error)
        return ExitCode.FAILED
    except SessionLostError as error:
        logging.error("%s", error)
        resource.setrlimit(resource.RLIMIT_CORE, (0, 0))  # leave no core file behind
        os.abort()  # a crash without a verdict: the launcher restarts the world, which resumes the run
    logging.info("%s: %s", "ok" if verdict.ok else "FAILED", verdict.reason)
    return verdict.exit_code


def _parse() -> argparse.Namespace:
    parser = argparse.ArgumentParser(
        prog="python -m world",
        description="The world of one run: it gives robots bodies and sensors, judges their motion, and "
        "writes events.jsonl and verdict.json. The exit code is the verdict: 0 kept its promises, 1 failed, "
        "2 wrong usage, 130 interrupted, 143 terminated.",
    )
    parser.add_argument(
        "run",
        type=Path,
        metavar="RUN",
        help="the run's folder, with scenario.toml, run.toml and, if anything is to fail, faults.toml",
    )
    parser.add_argument(
        "--session", type=Path, required=True, metavar="FILE", help="the world's session file"
    )
    parser.add_argument(
        "--resume", action="store_true", help="go on from the timeline in RUN, if there is one"
    )
    parser.add_argument(
        "--lifeline", action="store_true", help="end when stdin ends, so that no world outlives its launcher"
    )
    return parser.parse_args()


if __name__ == "__main__":
    sys.exit(main())
