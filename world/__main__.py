"""`python -m world`: the bodies, sensors, judgement and record of one run."""

import argparse
import logging
import os
import resource
import sys
from pathlib import Path

from protocol.errors import SessionLostError, UsageError
from protocol.exit_codes import ExitCode
from protocol.faults.plan import NO_FAULTS
from protocol.faults.plan import load as load_plan
from protocol.mission import Law
from protocol.network.session import read_session
from protocol.plain import PlainFormatter
from world.options import DEPLOYMENTS, seed_of, speed_of
from world.record.recorder import RecordingFailedError
from world.scenario.scenario import load
from world.shell import Request, run

STDIN = 0


def main() -> int:
    """Run the world; returns the verdict's exit code."""
    arguments = _parse()
    stderr = logging.StreamHandler()
    stderr.setFormatter(PlainFormatter("world: %(message)s"))
    logging.basicConfig(handlers=[stderr], level=logging.INFO)
    try:
        request = Request(
            scenario=load(
                arguments.scenario,
                robots=arguments.robots,
                law=arguments.law,
                deployment=arguments.deployment,
                seed=arguments.seed,
            ),
            session=read_session(arguments.session),
            out=arguments.out,
            seed=arguments.seed,
            speed=arguments.speed,
            lifeline=STDIN if arguments.lifeline else None,
            plan=NO_FAULTS if arguments.faults is None else load_plan(arguments.faults),
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
        resource.setrlimit(resource.RLIMIT_CORE, (0, 0))  # no file of this is to stay with the user
        os.abort()  # a crash, and not our verdict: the launcher starts the world again, which goes on
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
    parser.add_argument("--seed", type=seed_of, default=1, metavar="S", help="decides all draws; default 1")
    parser.add_argument("--law", choices=[law.value for law in Law], help="the law, not the scenario's")
    parser.add_argument("--deployment", choices=DEPLOYMENTS, help="random places, not the scenario's")
    parser.add_argument(
        "--speed", type=speed_of, default=1.0, metavar="X|max", help="simulated s per s; max: in lock-step"
    )
    parser.add_argument(
        "--faults", metavar="PLAN", help="a name in launch/faults or a .toml file: what goes wrong on purpose"
    )
    parser.add_argument(
        "--resume", action="store_true", help="go on from the timeline in --out, if there is one"
    )
    parser.add_argument(
        "--lifeline", action="store_true", help="end when stdin does, so that no launcher leaves us behind"
    )
    return parser.parse_args()


if __name__ == "__main__":
    sys.exit(main())
