"""A run as an object: live or rehearsed, finished or going on.

    run = clew.open("runs/latest")
    run.verdict, run.steps, run.at(12.3)
    run.entries(kind="step.*", robot=3, t=(2, 9))
    run.frame("poses")

Rule 1: it only reads. Of a run that goes on it shows what has been recorded up to now, and more with each
        look; of an unfinished one it has no verdict.
"""

import math
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import Any

from agents.navigation.law import Seen
from clew.api.entries import Entry
from clew.api.faults import Who, names, robot_of
from clew.api.frames import columns_of, frame_of
from clew.api.moment import Moment, moment_of
from clew.api.paths import path_of
from clew.api.picture import html_of
from clew.api.reading import Reading
from clew.fleet.summary import figures_line, recovery_lines, verdict_sentence
from clew.log.check import Finding, check, scenario_of
from clew.log.header import robots_of
from clew.log.journals.messages import Message, messages_of
from clew.log.journals.process import processes_of
from clew.log.law_asked import asked_for
from clew.log.replay import Replay, replay
from clew.log.timeline import Choice, Timeline, unknown_in
from clew.page.report import write_report
from clew.story.steps import Step
from clew.story.story import story_of
from protocol.errors import UsageError
from protocol.plain import plain
from world.judge.verdict import Verdict
from world.record.recorder import Header
from world.scenario.scenario import Scenario


def open_run(run: Path | str) -> "Run":
    """Open a run: its folder, or its `events.jsonl`.

    Raises:
        UsageError: there is no run.
    """
    return Run(run)


class Run:
    """A run, as far as it has been recorded."""

    def __init__(self, run: Path | str) -> None:
        self._reading = Reading(path_of("open", run, "the folder of a run, or its events.jsonl"))

    @property
    def folder(self) -> Path:
        """The folder with its files."""
        return self._reading.path.parent

    @property
    def header(self) -> Header:
        """What was asked for: scenario, seed, speed, fault plan."""
        return self._reading.header

    @property
    def scenario(self) -> Scenario:
        """The scenario, as it was run.

        Raises:
            UsageError: the header has none that this version can read.
        """
        return scenario_of(self._timeline)

    @property
    def seed(self) -> int:
        """The seed that decided all random draws."""
        return self.header.seed

    @property
    def verdict(self) -> Verdict | None:
        """The verdict (docs/verdict.md); None: the run goes on, or its world died before it could judge."""
        return self._reading.verdict

    @property
    def ok(self) -> bool:
        """Whether the run has ended, and has kept every promise."""
        return self.verdict is not None and self.verdict.ok

    @property
    def flaws(self) -> tuple[str, ...]:
        """What is missing from the log or cannot be read, in sentences."""
        return self._timeline.flaws

    @property
    def last_s(self) -> float:
        """The newest simulated time of an entry."""
        return max((entry.t_s for _, entry in self._reading.lines), default=0.0)

    # --- what happened ------------------------------------------------------------------------------

    def entries(
        self,
        kind: str | tuple[str, ...] = (),
        *,
        robot: int | str | None = None,
        step: int | None = None,
        source: Who = (),
        rule: str | tuple[str, ...] = (),
        key: str | tuple[str, ...] = (),
        t: tuple[float | None, float | None] | None = None,
    ) -> list[Entry]:
        """Entries in the recorder's order, chosen as `clew log cat` does.

        Args:
            kind: as `"step.*"`, or several; default: all.
            robot: only entries from this robot, `3` or `"r3"`, or about it.
            step: only entries of this switching step.
            source: `"world"`, `3` or `"r3"`, or several.
            rule: only injections of this fault rule, as `"kill-*"`.
            key: only entries about messages on this key, as `"link/r2/*"`.
            t: from when to when [simulated s], both included; None: from the start, or to the end.

        Raises:
            UsageError: no entry of such a run can be chosen: it has no such kind, source, robot, step, rule
                or key, or a time is no number.
        """
        said: object = t  # a notebook has no type checker
        if said is not None and not (isinstance(said, Sequence) and len(said) == 2):
            raise UsageError(f"t: must be two times, as (2, 9), got {t!r}")
        from_s, to_s = (None if each is None else _time("t", each) for each in t or (None, None))
        choice = Choice(
            kind=_all(kind),
            source=names(source),
            rule=_all(rule),
            key=_all(key),
            robot=None if robot is None else robot_of(robot, self._robots),
            step=step,
            from_s=from_s,
            to_s=to_s,
        )
        if (unknown := unknown_in(choice, self.header, self._reading.lines)) is not None:
            raise UsageError(unknown)
        return [Entry(*line) for line in self._reading.lines if choice.takes(*line)]

    @property
    def steps(self) -> tuple[Step, ...]:
        """The switching steps that leaders planned, with when and where each began and ended."""
        return story_of(self._reading.lines).all_steps()

    def seen(self, step: int | None = None, *, robot: int | str | None = None) -> Seen:
        """What the law was given for a switching step, by replay; you can call any law with it.

        Args:
            step: the number of the step; default: what it was given last, such as where the route was lost.
            robot: the leader, `1` or `"r1"`, where several robots have planned a step of this number.

        Raises:
            UsageError: there is no such step, or several; or its decision cannot be replayed.
        """
        leader = None if robot is None else robot_of(robot, self._robots)
        return asked_for(processes_of(self.folder), self._reading.lines, step=step, robot=leader)

    @property
    def poses(self) -> list[Entry]:
        """All true poses, with clearance and separation."""
        return self.entries("pose.sampled")

    @property
    def faults(self) -> list[Entry]:
        """All injections of faults."""
        return self.entries("fault.injected")

    @property
    def messages(self) -> list[Message]:
        """What robots received, and what was lost or refused; of messages to the world only the latter."""
        return messages_of(processes_of(self.folder), self._reading.lines)

    def at(self, t_s: float) -> Moment:
        """Where everybody was at that time, what everybody did, and who led; after the end, as at the end.

        Raises:
            UsageError: it is no time from the start on.
        """
        then_s = _time("at", t_s)
        if not 0.0 <= then_s < math.inf:
            raise UsageError(f"at: must be from 0 s on, got {then_s:g} s; the newest is run.last_s")
        return moment_of(self._reading.lines, then_s)

    def frame(self, name: str, *, to: str | None = None) -> Any:  # noqa: ANN401 - of a library that may be absent
        """A table: `poses`, `steps`, `messages`, `faults`, `states`, `waits`, `entries`, or a kind of entry.

        Args:
            name: the table.
            to: `pandas`, `polars` or `dicts`; default: the first of them that is installed.
        """
        return frame_of(columns_of(name, self._reading.lines, lambda: self.messages), to)

    # --- what is made of it -------------------------------------------------------------------------

    def check(self) -> Finding:
        """Judge the run again from its log alone."""
        return check(self._timeline)

    def replay(self, robot: int | str | None = None) -> Replay:
        """Replay every decision of every robot, or of one: new cores must decide as recorded."""
        return replay(self.folder, None if robot is None else robot_of(robot, self._robots))

    def report(self, path: Path | str | None = None) -> Path:
        """Write one HTML file that shows the run; default: `report.html` beside the log. Returns its path.

        Raises:
            UsageError: it cannot be written, or another file is there.
        """
        written, _flaws = write_report(
            self._reading.path, None if path is None else path_of("report", path, "a file")
        )
        return written

    @property
    def sentences(self) -> list[str]:
        """The run in a few sentences, its verdict first."""
        return [plain(sentence) for sentence in self._sentences()]

    def _sentences(self) -> Iterator[str]:
        if self.verdict is None:
            yield f"no verdict; recorded up to t={self.last_s:.1f} s"
            return
        yield verdict_sentence(self.verdict, self.scenario)
        yield figures_line(self.verdict)
        yield from recovery_lines(self.verdict)

    def __repr__(self) -> str:
        return f"<clew.Run {self.folder}: {self.sentences[0]}>"

    def _repr_html_(self) -> str:
        return html_of(self._timeline, self.sentences, self.verdict)

    @property
    def _robots(self) -> int:
        return robots_of(self.header)

    @property
    def _timeline(self) -> Timeline:
        lines = self._reading.lines
        return Timeline(self.header, tuple(lines), self._reading.flaws)


class EndedRun(Run):
    """A run that has come to its end, as `rehearse` and `finish` return it: it has its verdict."""

    @property
    def verdict(self) -> Verdict:
        """The verdict (docs/verdict.md).

        Raises:
            UsageError: its file is gone, or cannot be read.
        """
        verdict = super().verdict
        if verdict is None:
            raise UsageError(f"{self.folder}: the run has ended, and its verdict cannot be read")
        return verdict


def _time(name: str, given: object) -> float:
    """A time, such as one of numpy."""
    try:
        t_s = float(given)  # type: ignore[arg-type] # it raises for what is none
    except (TypeError, ValueError):
        t_s = math.nan
    if math.isnan(t_s):
        raise UsageError(f"{name}: must be a time [simulated s], got {given!r}")
    return t_s


def _all(given: str | tuple[str, ...]) -> tuple[str, ...]:
    """One word, or several."""
    return (given,) if isinstance(given, str) else given
