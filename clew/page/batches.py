"""A run's story for the page: entries in, batches out, for a complete or a live run. Pure.

    batches = Batches(header)              # None where the log has none that can be read
    for source, entry in lines:            # in the recorder's order
        batches.hear(source, entry)
    batches.add(verdict=verdict, flaws=flaws)
    batch = batches.batch(ended=True)      # JSON, for `clew.take(run_index, batch)` in the page

For a live run, each call of `batch()` gives the news; None if there are none.
"""

import math
from collections.abc import Iterator, Sequence
from typing import Any

import msgspec
import numpy as np

from clew.log.header import UNKNOWN
from clew.page.batch import (
    FORMAT,
    Batch,
    Clearance,
    Nearness,
    Start,
    StepRow,
    Subject,
    Track,
)
from clew.page.columns import MM, MRAD, MS, TENTH_MM, column
from clew.page.entries import Entries
from clew.page.judged import Measured, contradictions, unread
from clew.page.news import Told
from clew.story.distances import Clearances, Curve, Separations
from clew.story.shortfall import shortfall
from clew.story.steps import Ending, Step
from clew.story.story import Story
from clew.story.tracks import Tracks, needed
from protocol.arrays import Floats
from protocol.errors import UsageError
from protocol.faults.plan_text import FAULTS_FILE
from protocol.files.toml_text import toml_text
from protocol.frames import Point
from protocol.run_settings import SCENARIO_FILE
from protocol.timeline import Entry, PoseSampled, StepPlanned
from protocol.timeline.invariants import NAMES
from world.geometry.clearance import distances
from world.judge.monitor import Promises
from world.record.recorder import Header
from world.scenario.scenario import Scenario


class Batches:
    """Collects a run's entries until the next batch."""

    def __init__(self, header: Header | None, folder: str = "") -> None:
        """Begin with a run's header and the name of its folder."""
        self._scenario, self.flaws = _scenario_of(header)
        """The known flaws of the run, in sentences."""
        self._flaws_told: tuple[str, ...] = ()
        self._subject = None if header is None else _subject(header, folder, self._scenario)
        self._required_m = None if self._subject is None else self._subject.clearance_m_required
        self.story = Story()
        self._entries, self._tracks = Entries(self._leads_away), Tracks()
        self._clearances: Clearances | None = None
        self._separations: Separations | None = None
        if self._scenario is not None:
            radius_m = self._scenario.fleet.robot_radius_m
            self._clearances = Clearances(self._scenario.ground, radius_m)
            self._separations = Separations(self._scenario.movers, radius_m)
        self._measured: dict[Point, tuple[float, ...]] = {}
        self._told = Told()
        self._verdict: dict[str, Any] | None = None
        self._news = True

    def hear(self, source: str, entry: Entry) -> None:
        """Add an entry."""
        self._news = True
        self.story.hear(source, entry)
        if isinstance(entry.record, PoseSampled):
            self._tracks.hear(entry.t_s, entry.record)
        else:
            self._entries.hear(self.story.count, source, entry)

    def add(self, *, verdict: dict[str, Any] | None = None, flaws: Sequence[str] = ()) -> None:
        """Add the verdict as it is in its file, and further flaws of the log.

        An invalid verdict is only reported as a flaw.
        """
        self._news = True
        why = None if verdict is None else unread(verdict)
        self._verdict = self._verdict if verdict is None or why is not None else verdict
        self.flaws = (*self.flaws, *flaws, *([] if why is None else [why]))

    def batch(self, *, ended: bool = False) -> bytes | None:
        """The news as JSON; None if there are none. `ended`: nothing more will follow."""
        if not self._news and not ended:
            return None
        tracks, clearances = self._motion()
        separations, passings = (
            (None, None) if self._separations is None else self._separations.since(ended=ended)
        )
        if ended and self._verdict is not None:
            self._compare(self._verdict)
        batch = Batch(
            format=FORMAT,
            subject=self._subject,
            tracks=tracks,
            clearances=clearances,
            separations=_nearness(separations),
            passings=_nearness(passings),
            entries=self._entries.pack(),
            lanes=tuple(self._told.lanes(self.story)),
            links=self._told.links(self.story),
            strands=tuple(self._told.strands(self.story)),
            paths=self._told.paths(self.story),
            start=self._start(),
            steps=self._told.steps(self._steps()),
            losses=self._told.losses(self.story),
            books=self._told.books(self.story),
            end_s=self.story.end_s,
            ended=ended,
            verdict=self._verdict,
            shortfall=self._shortfall(),
            flaws=() if self.flaws == self._flaws_told else self.flaws,
        )
        self._subject, self._verdict, self._news = None, None, False
        self._flaws_told = self.flaws
        return msgspec.json.encode(batch)

    def _shortfall(self) -> str:
        """The shortfall of the verdict's least clearance or, without a verdict, of the least so far."""
        measured_m = math.inf if self._clearances is None else self._clearances.least_m
        said_m = None if self._verdict is None else self._verdict["clearance_m_min"]
        least_m = measured_m if said_m is None else said_m
        if self._scenario is None or math.isinf(least_m):
            return ""
        short = shortfall(self._scenario.law, least_m)
        return f"Clearance {least_m:.4f} m: {short}" if short else ""

    def _compare(self, verdict: dict[str, Any]) -> None:
        """Report differences between the verdict and the log, after all entries."""
        if self._clearances is None or self._separations is None:
            return  # no distance is judged, which is a separate flaw
        measured = Measured(
            clearance_m=self._clearances.least_m,
            moving_clearance_m=self._separations.passed_m,
            separation_m=self._separations.apart_m,
            steps=self.story.steps.finished_count,
        )
        self.flaws = (*self.flaws, *contradictions(measured, verdict, whole=not self.flaws))

    def _motion(self) -> tuple[tuple[Track, ...], tuple[Clearance, ...]]:
        tracks, clearances = list[Track](), list[Clearance]()
        for robot, rows in self._tracks.take():
            tracks.append(_track(robot, rows))
            if self._separations is not None:
                self._separations.hear(robot, rows)
            clear = None if self._clearances is None else self._clearances.along(robot, rows)
            if clear is not None:
                t_s, least_m = clear
                clearances.append(Clearance(robot=robot, t=column(t_s, MS), least=column(least_m, TENTH_MM)))
        return tuple(tracks), tuple(clearances)

    def _leads_away(self, plan: StepPlanned) -> bool:
        promised_m = plan.promised_clearance_m
        return promised_m is not None and promised_m < (self._required_m or 0.0)

    def _start(self) -> Start | None:
        """The leader's first place; sent once."""
        if (start := self._told.start(self.story)) is None:
            return None
        return Start(t_s=start.t_s, robot=start.robot, distances_m=self._distances_m(start.at))

    def _steps(self) -> Iterator[StepRow]:
        """All rows of the step table so far."""
        steps, finished = self.story.all_steps(), 0
        next_s = [*(step.t_s for step in steps[1:]), np.inf]
        for place, (step, end_s) in enumerate(zip(steps, next_s, strict=False)):
            is_finished = step.end is not None and step.end.how is Ending.FINISHED
            finished += is_finished
            yield self._step(place, step, end_s, finished if is_finished else 0)

    def _step(self, place: int, step: Step, end_s: float, position: int) -> StepRow:
        end, plan = step.end, step.plan
        at = end.at if end is not None and position else None
        return StepRow(
            place=place,
            step=step.number,
            robot=step.robot,
            from_s=step.t_s,
            to_s=None if end is None else min(end.t_s, end_s),
            end="" if end is None else str(end.how),
            length_m=plan.length_m,
            promised_m=plan.promised_clearance_m,
            leads_away=self._leads_away(plan),
            clearance_m=None if end is None else end.clearance_m,
            x_m=None if at is None else at.x_m,
            y_m=None if at is None else at.y_m,
            position=position,
            distances_m=() if at is None else self._distances_m(at),
        )

    def _distances_m(self, at: Point) -> tuple[float, ...]:
        """The distances from a place; each place is measured once."""
        if self._scenario is not None and at not in self._measured:
            here_m = np.array([at.x_m, at.y_m])
            self._measured[at] = tuple(distances(self._scenario.ground, here_m).tolist())
        return self._measured.get(at, ())


def _track(robot: int, rows: Floats) -> Track:
    """The track of a body through these samples."""
    kept = rows[needed(rows)]
    return Track(
        robot=robot,
        t=column(kept[:, 0], MS),
        x=column(kept[:, 1], MM),
        y=column(kept[:, 2], MM),
        heading=column(kept[:, 3], MRAD),
    )


def _nearness(curve: Curve | None) -> Nearness | None:
    if curve is None:
        return None
    t_s, least_m, robots, others = curve
    return Nearness(
        t=column(t_s, MS), least=column(least_m, TENTH_MM), robot=robots.tolist(), other=others.tolist()
    )


def _subject(header: Header, folder: str, scenario: Scenario | None) -> Subject:
    promises = None if scenario is None else Promises.of(scenario)
    return Subject(
        run=header.run,
        folder=folder,
        seed=None if _is_unknown(header) else header.seed,
        speed=header.speed,
        started_at=header.started_at,
        scenario=header.scenario,
        versions=header.versions,
        asked=dict(_asked(header)),
        clearance_m_required=None if promises is None else promises.clearance_m_required,
        separation_m_required=None if promises is None else promises.separation_m_required,
        invariants=NAMES,
    )


def _asked(header: Header) -> Iterator[tuple[str, str]]:
    for name, table in ((SCENARIO_FILE, header.scenario), (FAULTS_FILE, header.faults)):
        if table:
            try:
                yield name, toml_text(table)
            except (TypeError, ValueError):  # written by hand: TOML cannot say all that JSON can
                yield name, msgspec.json.format(msgspec.json.encode(table)).decode()


def _is_unknown(header: Header) -> bool:
    """Whether the header is a substitute, because the subject of the run is unknown."""
    return header.scenario_hash == UNKNOWN.scenario_hash and header.seed == UNKNOWN.seed


def _scenario_of(header: Header | None) -> tuple[Scenario | None, tuple[str, ...]]:
    """The scenario for judging distances, and the flaw if there is none."""
    if header is None:
        return None, ()
    try:
        return msgspec.convert(header.scenario, Scenario), ()
    except (msgspec.ValidationError, UsageError) as error:
        return None, (f"no distances: the scenario in the header cannot be read: {error}",)
