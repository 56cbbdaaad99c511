"""`python -m world`: the bodies, sensors, judgement and timeline of one run."""

from protocol.process.loading import loading

with loading():
    from protocol.process.allocation import allocate_from_one_arena

    allocate_from_one_arena()  # before any import starts a thread
    import argparse
    import logging
    import os
    import resource
    import sys
    from collections.abc import Sequence
    from dataclasses import replace
    from pathlib import Path

    from protocol.errors import SessionLostError, UsageError
    from protocol.exit_codes import ExitCode
    from protocol.network.session import Session, read_session
    from protocol.plain import PlainFormatter
    from protocol.run_settings import SCENARIO_FILE, check_is_run, read_plan, read_settings
    from world.judge.hulls import AllHulls
    from world.judge.together import TogetherVerdict, pass_together
    from world.judge.verdict import Verdict
    from world.life import Request
    from world.record.recorder import RecordingFailedError
    from world.record.run_files import save_verdict
    from world.scenario.fleets import load_fleets
    from world.scenario.scenario import Scenario, load
    from world.shell import run

STDIN = 0


def main() -> int:
    """Run the world; returns the verdict's exit code."""
    arguments = _parse()
    stderr = logging.StreamHandler()
    stderr.setFormatter(PlainFormatter("world: %(message)s"))
    logging.basicConfig(handlers=[stderr], level=logging.INFO)
    try:
        sessions = [(path.parent, read_session(path)) for path in arguments.session]
        verdict = _run_one(arguments, *sessions[0]) if len(sessions) == 1 else _run_all(arguments, sessions)
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


def _run_one(arguments: argparse.Namespace, private: Path, session: Session) -> Verdict:
    scenario = load(str(arguments.run / SCENARIO_FILE))
    return run([_request(arguments, arguments.run, private, session, scenario)])[0]


def _run_all(arguments: argparse.Namespace, sessions: Sequence[tuple[Path, Session]]) -> TogetherVerdict:
    """Run several fleets on one ground."""
    if arguments.resume:
        raise UsageError("--resume: the clocks of several fleets would go on from different times")
    folder = arguments.run
    check_is_run(folder)
    shared = load_fleets(str(folder / SCENARIO_FILE))
    # Each fleet's folder has its scenario, too. To read 200, each with the obstacles of all, takes 3 s.
    scenarios = shared.scenarios()
    requests = {
        session.fleet: replace(
            _request(arguments, folder / session.fleet, private, session, scenarios[session.fleet]),
            fleet=session.fleet,
        )
        for private, session in sessions
    }
    hulls = AllHulls({name: each.scenario for name, each in requests.items()})
    verdicts = dict(zip(requests, run(list(requests.values()), hulls), strict=True))
    verdict = pass_together(shared.name, read_settings(folder).seed, verdicts, hulls.between)
    save_verdict(verdict, folder)
    return verdict


def _request(
    arguments: argparse.Namespace, folder: Path, private: Path, session: Session, scenario: Scenario
) -> Request:
    check_is_run(folder)
    settings = read_settings(folder)
    return Request(
        scenario=scenario,
        session=session,
        out=folder,
        seed=settings.seed,
        speed=settings.speed,
        held=settings.held,
        lifeline=STDIN if arguments.lifeline else None,
        plan=read_plan(folder),
        private=private,
        resume=arguments.resume,
    )


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
        "--session",
        type=Path,
        required=True,
        action="append",
        metavar="FILE",
        help="the world's session file; of several fleets one for each, and RUN has a folder for each",
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
