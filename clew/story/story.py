"""The story of a run for the page: entries in, batches out. Pure; the whole run at once, or as it happens.

    story = Story(header)                  # None where the log has none that can be read
    for source, entry in lines:            # in the recorder's order
        story.hear(source, entry)
    story.add(verdict=verdict, flaws=flaws)
    batch = story.batch(ended=True)        # JSON, for `clew.take(run_index, batch)` in the page

A live run calls `batch()` whenever it likes, and gets what is new; None where nothing is.
"""

from collections.abc import Sequence
from typing import Any

import msgspec

from clew.log.header import UNKNOWN
from clew.story import lanes, strands
from clew.story.batch import (
    FORMAT,
    Batch,
    Clearance,
    Lane,
    LinkChange,
    Position,
    Strand,
    Subject,
    Track,
)
from clew.story.distances import Clearances, Separations
from clew.story.entries import Entries
from clew.story.judged import Measured, contradictions, unread
from clew.story.lanes import Lanes
from clew.story.strands import Positions, Strands
from clew.story.tracks import Tracks, pack
from protocol.errors import UsageError
from protocol.keys import WORLD
from protocol.timeline import Entry, PoseSampled
from world.judge.monitor import Promises
from world.record.recorder import Header
from world.scenario.scenario import Scenario


class Story:
    """What has been heard of a run and not been told yet."""

    def __init__(self, header: Header | None, folder: str = "") -> None:
        """Of the run that this header begins, in the folder of this name."""
        self._scenario, self.flaws = _scenario_of(header)
        """What is wrong with the run, as far as it is known, in sentences."""
        self._flaws_told: tuple[str, ...] = ()
        self._subject = None if header is None else _subject(header, folder, self._scenario)
        self._entries, self._tracks = Entries(), Tracks()
        self._lanes, self._strands = Lanes(), Strands()
        self._positions = Positions(None if self._scenario is None else self._scenario.ground)
        self._clearances: Clearances | None = None
        self._separations: Separations | None = None
        if self._scenario is not None:
            radius_m = self._scenario.fleet.robot_radius_m
            self._clearances = Clearances(self._scenario.ground, radius_m)
            self._separations = Separations(self._scenario.movers, radius_m)
        self._changes: list[Lane | LinkChange | Strand | Position] = []
        self._steps = 0
        self._verdict: dict[str, Any] | None = None
        self._heard = 0
        self._end_s = 0.0
        self._news = True

    def hear(self, source: str, entry: Entry) -> None:
        """Take an entry in."""
        record = entry.record
        self._news = True
        self._heard += 1
        self._end_s = max(self._end_s, entry.t_s)
        if isinstance(record, PoseSampled):
            self._tracks.hear(entry.t_s, record)
            return
        self._entries.hear(self._heard, source, entry)
        kind = type(record)
        if kind in lanes.KINDS:
            self._changes.extend(self._lanes.hear(source, entry))
        if kind not in strands.KINDS:
            return
        if (strand := self._strands.hear(source, entry)) is not None:
            self._changes.append(strand)
        if source == WORLD:
            positions = list(self._positions.hear(entry))
            self._steps += sum(position.step > 0 for position in positions)
            self._changes.extend(positions)

    def add(self, *, verdict: dict[str, Any] | None = None, flaws: Sequence[str] = ()) -> None:
        """Take in the verdict as it stands in its file, and what more is known to be wrong with the log.

        What is no verdict is only named as a flaw.
        """
        self._news = True
        why = None if verdict is None else unread(verdict)
        self._verdict = self._verdict if verdict is None or why is not None else verdict
        self.flaws = (*self.flaws, *flaws, *([] if why is None else [why]))

    def batch(self, *, ended: bool = False) -> bytes | None:
        """What is new, as JSON; None where nothing is. `ended`: nothing more will come."""
        if not self._news and not ended:
            return None
        tracks, clearances = self._motion()
        separations, passings = (
            (None, None) if self._separations is None else self._separations.pack(ended=ended)
        )
        if ended and self._verdict is not None:
            self._compare(self._verdict)
        batch = Batch(
            format=FORMAT,
            subject=self._subject,
            tracks=tracks,
            clearances=clearances,
            separations=separations,
            passings=passings,
            entries=self._entries.pack(),
            lanes=tuple(each for each in self._changes if isinstance(each, Lane)),
            links=tuple(each for each in self._changes if isinstance(each, LinkChange)),
            strands=tuple(each for each in self._changes if isinstance(each, Strand)),
            positions=tuple(each for each in self._changes if isinstance(each, Position)),
            paths=self._strands.paths(),
            end_s=self._end_s,
            ended=ended,
            verdict=self._verdict,
            flaws=() if self.flaws == self._flaws_told else self.flaws,
        )
        self._subject, self._verdict, self._news = None, None, False
        self._flaws_told = self.flaws
        self._changes.clear()
        return msgspec.json.encode(batch)

    def _compare(self, verdict: dict[str, Any]) -> None:
        """Name what the log, of which all has been heard, says otherwise than the verdict."""
        if self._clearances is None or self._separations is None:
            return  # nothing is judged, and that is a flaw by itself
        measured = Measured(
            clearance_m=self._clearances.least_m,
            moving_clearance_m=self._separations.passed_m,
            separation_m=self._separations.apart_m,
            steps=self._steps,
        )
        self.flaws = (*self.flaws, *contradictions(measured, verdict, whole=not self.flaws))

    def _motion(self) -> tuple[tuple[Track, ...], tuple[Clearance, ...]]:
        tracks, clearances = list[Track](), list[Clearance]()
        for t_s, pose in self._tracks.newest.values():
            self._strands.stand(t_s, pose)
        for robot, rows in self._tracks.take():
            tracks.append(pack(robot, rows))
            if self._separations is not None:
                self._separations.hear(robot, rows)
            clear = None if self._clearances is None else self._clearances.pack(robot, rows)
            if clear is not None:
                clearances.append(clear)
        return tuple(tracks), tuple(clearances)


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
        clearance_m_required=None if promises is None else promises.clearance_m_required,
        separation_m_required=None if promises is None else promises.separation_m_required,
    )


def _is_unknown(header: Header) -> bool:
    """Whether what was run is not said."""
    return header.scenario_hash == UNKNOWN.scenario_hash and header.seed == UNKNOWN.seed


def _scenario_of(header: Header | None) -> tuple[Scenario | None, tuple[str, ...]]:
    """What distances are judged by, and what is wrong where nothing is."""
    if header is None:
        return None, ()
    try:
        return msgspec.convert(header.scenario, Scenario), ()
    except (msgspec.ValidationError, UsageError) as error:
        return None, (f"no distances: the header's scenario cannot be judged by: {error}",)
