"""The summary of a run that has ended.

If the scenario has a Table I, the table comes first, beside the measured distances. The figures follow. The
last line is the verdict in a sentence and the run's folder.
"""

from collections.abc import Iterator
from pathlib import Path

import msgspec

from clew.log import timeline
from clew.log.check import scenario_of
from clew.log.timeline import Timeline
from clew.story.shortfall import shortfall
from protocol.errors import UsageError
from protocol.plain import plain
from world.judge.recovery import Death
from world.judge.table import Rows, measure
from world.judge.tally import Tally
from world.judge.verdict import Verdict
from world.record.run_files import read_verdict
from world.scenario.scenario import Scenario


def report(run: str, read: Timeline, verdict: Verdict) -> Iterator[str]:
    """The lines of a report as plain text; `run` is the folder by the path that the user gave."""
    yield from map(plain, _lines(run, read, verdict))


def _lines(run: str, read: Timeline, verdict: Verdict) -> Iterator[str]:
    scenario = scenario_of(read)
    if scenario.table_m is not None:
        tally = Tally()
        for source, entry in read.lines:
            tally.hear(source, entry)
        yield from table_lines(scenario.table_m, measure(scenario, tally.switching_positions))
        yield rms_line(scenario.table_m, verdict)
        yield ""
    yield figures_line(verdict)
    if verdict.slowness is not None:
        yield verdict.slowness
    yield from recovery_lines(verdict)
    yield f"{verdict_sentence(verdict, scenario)} Run: {run}"


def table_lines(paper_m: Rows, measured_m: Rows) -> Iterator[str]:
    """Two tables side by side, row by row; a switching position that was never reached has no value."""
    columns = len(paper_m[0])
    yield "Distance from the leader to each obstacle [m], in Table I of the paper and as measured"
    yield "".join(["position", *(f"{f'obstacle {column + 1}':>20}" for column in range(columns))])
    yield "".join(["        ", *(f"{'paper':>10}{'measured':>10}" for _ in range(columns))])
    for row, paper in enumerate(paper_m):
        measured = measured_m[row] if row < len(measured_m) else (None,) * columns
        pairs = (
            f"{printed:10.3f}{'-' if here is None else format(here, '.3f'):>10}"
            for printed, here in zip(paper, measured, strict=True)
        )
        yield "".join([f"{row + 1:>8}", *pairs])


def rms_line(paper_m: Rows, verdict: Verdict) -> str:
    """The RMS difference of the two tables."""
    if verdict.table_rms_m is None:
        return "Not all switching positions were reached: no RMS error against Table I"
    count = sum(len(row) for row in paper_m)
    return f"RMS error against Table I: {verdict.table_rms_m:.4f} m over {count} distances"


def figures_line(verdict: Verdict) -> str:
    """The effort of the run: steps, distance, time, events and messages."""
    steps = "switching step" if verdict.switching_steps == 1 else "switching steps"
    return (
        f"{verdict.switching_steps} {steps} finished, {verdict.planning_events} planning events, "
        f"{verdict.path_m:.2f} m driven by all; {verdict.sim_s:.1f} s simulated in {verdict.wall_s:.1f} s; "
        f"{verdict.events.recorded} events, {verdict.events.missing + verdict.events.lost} missing; "
        f"{verdict.messages.sent} messages, {verdict.messages.unaccounted} unaccounted for"
    )


def recovery_lines(verdict: Verdict) -> Iterator[str]:
    """The faults of the run and the recovery from them; nothing if there were none."""
    if verdict.messages.injected:
        counts = ", ".join(f"{count} by {fault}" for fault, count in verdict.messages.injected.items())
        yield f"messages removed by fault rules: {counts}"
    if elsewhere := verdict.messages.injected_left_out:
        counts = ", ".join(f"{count} by {fault}" for fault, count in elsewhere.items())
        yield f"messages removed on links without final counts: {counts}"
    for death in verdict.deaths:
        yield f"robot {death.robot} {_lost(death)}: {_mended(death)}"
    for succession in verdict.successions:
        before = "nobody" if succession.before is None else f"robot {succession.before}"
        from_s = f"from t={succession.recovered_s:.1f} s on"
        yield f"robot {succession.robot} leads in the place of {before} {from_s}"
    for heal in verdict.heals:
        yield f"the strand healed at t={heal.recovered_s:.1f} s, of {len(heal.members)} robots"
    if verdict.unstruck:
        yield f"fault rules that never struck: {', '.join(verdict.unstruck)}"


def _lost(death: Death) -> str:
    who = "as asked" if death.ordered else "by itself"
    if death.returned_s is None:
        return f"died {who} at t={death.cause_s:.1f} s"
    # Its process was frozen or cut off. It lives, so a reader must not look for a crash.
    return f"was silent from t={death.cause_s:.1f} s to t={death.returned_s:.1f} s, {who}"


def _mended(death: Death) -> str:
    if death.detected_s is None and death.recovered_s is None:
        return "not noticed by any robot"
    if death.detected_s is None:  # it died while a view formed, for example
        noticed = "no link to it was broken"
    else:
        noticed = f"noticed after {death.detected_s - death.cause_s:.1f} s"
    if death.recovered_s is None:
        return f"{noticed}, never healed"
    return f"{noticed}, healed after {death.recovered_s - death.cause_s:.1f} s"


def verdict_sentence(verdict: Verdict, scenario: Scenario) -> str:
    """The verdict and the least clearance; for a law without a promise, a comparison with --law certified."""
    word = "OK" if verdict.ok else "FAILED"
    sentence = f"{word}: {verdict.reason}; {verdict.robots_arrived} of {verdict.robots} robots arrived"
    if verdict.clearance_m_min is None:
        return f"{sentence}."
    least_m = verdict.clearance_m_min
    if short := shortfall(scenario.law, least_m):
        return f"{sentence}, clearance {least_m:.4f} m: {short}"
    return f"{sentence}, clearance {least_m:.4f} m of {verdict.clearance_m_required:.4f} m required."


def summary_of(run: str) -> str:
    """The report of a run that has its verdict; `run` is the path that the user gave.

    Raises:
        UsageError: there is no such run.
    """
    try:
        verdict = read_verdict(Path(run))
        return "\n".join(report(run, timeline.read(Path(run)), verdict)) + "\n"
    except (OSError, msgspec.MsgspecError, UsageError) as error:
        raise UsageError(f"report: {run}: {error}") from error
