"""The verdict of a run whose world has not written one: failed, and it says only why.

Rule 1: a run that had begun has a verdict, in every end but the loss of its folder or of the disk.
Rule 2: the launcher judges nothing: a long log takes longer than the end of a run may.
"""

import contextlib

from clew.fleet.output import has_content
from clew.fleet.prepare import Prepared
from protocol.exit_codes import ExitCode
from protocol.timeline.invariants import INVARIANTS
from world.judge.books import Messages
from world.judge.hulls import AllHulls
from world.judge.monitor import Promises
from world.judge.together import TogetherVerdict, pass_together
from world.judge.verdict import VERDICT_FILE, Events, Verdict
from world.record.recorder import EVENTS_FILE, RecordingFailedError
from world.record.run_files import BEGUN_FILE, save_verdict
from world.scenario.scenario import Scenario

REASON = "the run ended without a verdict of its world"
REMOVED = "the run's folder was removed"


def has_begun(run: Prepared) -> bool:
    """Whether the run has ever had a timeline."""
    return any(
        (run.private / fleet / BEGUN_FILE).exists() or has_content(run.folder / fleet / EVENTS_FILE)
        for fleet in run.fleets or ("",)
    )


def stand_in(run: Prepared, code: int) -> Verdict | TogetherVerdict | None:
    """Write the verdict that a run lacks; None if it has one, or never began.

    Args:
        run: the run, whose processes have ended.
        code: the exit code of the run.
    """
    if has_content(run.folder / VERDICT_FILE) or not has_begun(run):
        return None
    verdict = _failed_on_all(run, code or ExitCode.FAILED)
    if run.folder.exists():
        with contextlib.suppress(RecordingFailedError):  # the disk is lost: it is printed at least
            save_verdict(verdict, run.folder)
    return verdict


def _failed_on_all(run: Prepared, code: int) -> Verdict | TogetherVerdict:
    if isinstance(run.scenario, Scenario):
        return _failed(run, run.scenario, code)
    scenarios = run.scenario.scenarios()
    verdicts = {name: _failed(run, each, code) for name, each in scenarios.items()}
    return pass_together(run.scenario.name, run.settings.seed, verdicts, AllHulls(scenarios).between)


def _failed(run: Prepared, scenario: Scenario, code: int) -> Verdict:
    settings, promises = run.settings, Promises.of(scenario)
    return Verdict(
        ok=False,
        exit_code=code,
        reason=REASON if run.folder.exists() else REMOVED,
        scenario=scenario.name,
        seed=settings.seed,
        robots=scenario.fleet.robots,
        law=scenario.law.law,
        speed=settings.speed,
        started_at=run.started_at,
        no_route=False,
        goal_reached=False,
        robots_arrived=0,
        clearance_m_min=None,
        clearance_m_required=promises.clearance_m_required,
        moving_clearance_m_min=None,
        separation_m_min=None,
        separation_m_required=promises.separation_m_required,
        violations=0,
        violations_by_invariant=dict.fromkeys(INVARIANTS, 0),
        switching_steps=0,
        planning_events=0,
        scans=0,
        path_m=0.0,
        table_rms_m=None,
        sim_s=0.0,
        wall_s=0.0,
        cpu_s=0.0,
        messages=Messages(sent=0, received=0, injected={}, refused=0, unaccounted=0, left_out=()),
        events=Events(recorded=0, missing=0),
        deaths=(),
    )
