"""The batch format: the data of a run for the page, complete in a report or piece by piece from a live run.

Rule 1: a run is a sequence of batches; `clew.take(run_index, batch)` takes them in order. The first one has
        `subject`; empty fields are left out.
Rule 2: all entries of the timeline are included; pose.sampled becomes `tracks`. In a track, a body moves
        straight and evenly between places, never more than `PLACE_TOLERANCE_M` from the log's poses.
Rule 3: a column is a list of integers, each as the difference to the one before; the first one of a batch is
        absolute. Times are in ms, places in mm, angles in mrad, judged distances in 0.1 mm.
Rule 4: these replace earlier data: `paths` by epoch, `steps` by place, `books`, `verdict`, `shortfall` and
        `flaws`. Everything else is appended.
"""

from typing import Any

from msgspec import Struct

from clew.story.links import LinkChange
from clew.story.losses import Book

FORMAT = "clew-page/1"
PLACE_TOLERANCE_M = 0.001  # per coordinate: the largest error by rounding and by omitted places together

Column = list[int]


class Subject(Struct, frozen=True, kw_only=True, omit_defaults=True):
    """The fixed facts of a run."""

    run: str
    folder: str = ""
    """The name of its folder, or of a single log file."""
    seed: int | None = None
    """None: the header is damaged."""
    speed: float | None
    started_at: str
    scenario: dict[str, Any]
    """As in the header, unchecked; the next two fields hold the limits derived from it."""
    versions: dict[str, str]
    asked: dict[str, str] = {}
    """The files of the request, as TOML: the scenario and the fault plan, as the header has them."""
    clearance_m_required: float | None = None
    """None: the scenario is of another version, so no distance is judged."""
    separation_m_required: float | None = None
    invariants: dict[str, str] = {}
    """Their names by code: the verdict has the codes alone."""


class Track(Struct, frozen=True, kw_only=True):
    """The places of a robot's body."""

    robot: int
    t: Column
    x: Column
    y: Column
    heading: Column
    """Unwrapped: it has no jumps by a full turn."""


class Clearance(Struct, frozen=True, kw_only=True):
    """A hull's clearance from fixed obstacles: the least since the time before, judged as by the monitor."""

    robot: int
    t: Column
    least: Column


class Nearness(Struct, frozen=True, kw_only=True):
    """The least distance in the fleet since the previous time, and its two sides."""

    t: Column
    least: Column
    robot: list[int]
    other: list[int]
    """The other robot, or the moving obstacle, counted from 0."""


class Lane(Struct, frozen=True, kw_only=True):
    """A robot's reason to wait, from a time on; its track shows whether it drives."""

    robot: int
    t_s: float
    state: str
    """`free`, `lining up`, `aside`, `holding` for one behind, `waiting` for a link, `arrived`, `dead`."""


class StrandRow(Struct, frozen=True, kw_only=True):
    """The order of the strand from a time on, leader first."""

    t_s: float
    epoch: int
    turn: int
    """Of the fence that lets it drive; orders of earlier turns of the epoch are not of the strand."""
    order: tuple[int, ...]


class Start(Struct, frozen=True, kw_only=True):
    """The leader's place before the first step: the first row of the step table."""

    t_s: float
    robot: int
    distances_m: tuple[float, ...]
    """From its centre to each obstacle of the scenario, as in the paper's Table I; not rounded."""


class StepRow(Struct, frozen=True, kw_only=True):
    """A switching step: a row of the step table."""

    place: int
    """Its index among all steps of the run, from 0."""
    step: int
    robot: int
    """The leader."""
    from_s: float
    to_s: float | None
    """None: it is under way."""
    end: str
    """`finished`, `abandoned` or `broken off`; empty: under way."""
    length_m: float
    promised_m: float | None
    leads_away: bool
    """It promises less than required: an obstacle has come nearer, and the step leads away from it."""
    clearance_m: float | None = None
    """The least clearance in the step; None: it was not finished, or there is no obstacle."""
    x_m: float | None = None
    y_m: float | None = None
    """The leader's place at the end of a finished step; None: it was not finished."""
    position: int = 0
    """Its number among the finished steps, from 1: its row in Table I, where row 0 is the start."""
    distances_m: tuple[float, ...] = ()
    """The distances from there, as at the start."""


class Losses(Struct, frozen=True, kw_only=True):
    """The link messages that faults removed or damaged."""

    t: Column
    sender: list[int]
    receiver: list[int]


class Batch(Struct, frozen=True, kw_only=True, omit_defaults=True):
    """A piece of a run."""

    format: str
    subject: Subject | None = None
    tracks: tuple[Track, ...] = ()
    clearances: tuple[Clearance, ...] = ()
    separations: Nearness | None = None
    """Hull to hull."""
    passings: Nearness | None = None
    """From moving hulls to moving obstacles."""
    entries: dict[str, dict[str, list[Any]]] = {}
    """By kind: `i`, the entry's index in the log, and `t` in ms, both columns; `source`, a list of names;
    then a list for each field of the kind. A place is a pair `[x, y]`.

    All kinds except the most frequent ones also have `says`, their sentences; null: not of interest. Of
    `step.planned` there is also `ends`: the two end points of each gap, right and left; null: not known.
    """
    lanes: tuple[Lane, ...] = ()
    links: tuple[LinkChange, ...] = ()
    strands: tuple[StrandRow, ...] = ()
    paths: dict[str, list[tuple[float, float]]] = {}
    """By epoch: all corners of the strand's path; arc length starts at the first."""
    start: Start | None = None
    steps: tuple[StepRow, ...] = ()
    losses: Losses | None = None
    books: tuple[Book, ...] = ()
    end_s: float | None = None
    """The newest time of the run so far."""
    ended: bool = False
    """Nothing more will follow."""
    verdict: dict[str, Any] | None = None
    """`verdict.json` as in the run's folder."""
    shortfall: str = ""
    """For a law that promises no clearance: the shortfall of the least clearance, in a sentence."""
    flaws: tuple[str, ...] = ()
    """All known flaws of the log, in sentences."""
