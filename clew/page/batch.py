"""The batch format: what the page is told of a run, whole in a report or piece by piece from a live one.

Rule 1: a run is a sequence of batches, and `clew.take(run_index, batch)` takes each in its order. The first
        has `subject`; a field that has nothing to say is left out.
Rule 2: no entry of the timeline is left out but pose.sampled, which is `tracks`. There a body goes straight
        and evenly from one place to the next, and is never further than `PLACE_TOLERANCE_M` from the log's.
Rule 3: a column is a list of whole numbers, each less the one before it; the first of a batch stands whole.
        Times are in ms, places in mm, angles in mrad, distances that are judged in 0.1 mm.
Rule 4: these replace what there is: `paths` by epoch, `steps` by place, `books`, `verdict`, `shortfall` and
        `flaws`. All else is added to it.
"""

from typing import Any

from msgspec import Struct

from clew.story.links import LinkChange
from clew.story.losses import Book

FORMAT = "clew-page/1"
PLACE_TOLERANCE_M = 0.001  # in each coordinate: what rounding and leaving out places may be off by, together

Column = list[int]


class Subject(Struct, frozen=True, kw_only=True, omit_defaults=True):
    """What was run, of which nothing changes."""

    run: str
    folder: str = ""
    """The name of the folder in which it stands, or of a log by itself."""
    seed: int | None = None
    """None: the header is damaged, and does not say."""
    speed: float | None
    started_at: str
    scenario: dict[str, Any]
    """As the header has it, unchecked; what is judged by it is in the two fields below."""
    versions: dict[str, str]
    clearance_m_required: float | None = None
    """None: the scenario is of another version, and nothing of the run is judged by it."""
    separation_m_required: float | None = None


class Track(Struct, frozen=True, kw_only=True):
    """Where a robot's body was."""

    robot: int
    t: Column
    x: Column
    y: Column
    heading: Column
    """Unwound: it does not jump by a turn."""


class Clearance(Struct, frozen=True, kw_only=True):
    """How clear a hull was of what never moves: the least since the time before, as the monitor judges it."""

    robot: int
    t: Column
    least: Column


class Nearness(Struct, frozen=True, kw_only=True):
    """The least distance in the fleet since the time before, and whose."""

    t: Column
    least: Column
    robot: list[int]
    other: list[int]
    """The other robot, or the moving obstacle, counted from 0."""


class Lane(Struct, frozen=True, kw_only=True):
    """What holds a robot back from a time on; whether it drives, its track says."""

    robot: int
    t_s: float
    state: str
    """`free`, `lining up`, `holding` for the robot behind, `waiting` for a link, `arrived` or `dead`."""


class StrandRow(Struct, frozen=True, kw_only=True):
    """The order of the strand from a time on, leader first."""

    t_s: float
    epoch: int
    order: tuple[int, ...]


class Start(Struct, frozen=True, kw_only=True):
    """Where the leader stood before the first step: the first row of the step table."""

    t_s: float
    robot: int
    distances_m: tuple[float, ...]
    """To each obstacle of the scenario, from the centre, as in the paper's Table I; not rounded."""


class StepRow(Struct, frozen=True, kw_only=True):
    """A switching step: a row of the step table."""

    place: int
    """Among all steps of the run, from 0."""
    step: int
    robot: int
    """That led."""
    from_s: float
    to_s: float | None
    """None: it is under way."""
    end: str
    """`finished`, `abandoned` or `broken off`; empty: it is under way."""
    length_m: float
    promised_m: float | None
    leads_away: bool
    """It promises less than is required: something has come nearer, and the step leads away from that."""
    clearance_m: float | None = None
    """The least in the step; None: it was not finished, or there is no obstacle."""
    x_m: float | None = None
    y_m: float | None = None
    """Where the leader stood when it was finished; None: it was not."""
    position: int = 0
    """Which step it was that was finished, from 1: its row in Table I, where row 0 is the start."""
    distances_m: tuple[float, ...] = ()
    """From there, as those of the start."""


class Losses(Struct, frozen=True, kw_only=True):
    """The messages of links that faults took or damaged."""

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
    """Hulls that moved, to moving obstacles."""
    entries: dict[str, dict[str, list[Any]]] = {}
    """By kind: `i`, which entry of the log it was, `t` in ms and `source`, all columns but `source`, which
    holds the source's name; then a list for each field of the kind. A place is a pair `[x, y]`.

    Of all but the most frequent kinds also `says`, their sentences; null: nobody looks for this one. Of
    `step.planned` also `ends`: between which points each gap opens, right and left; null: that is not known.
    """
    lanes: tuple[Lane, ...] = ()
    links: tuple[LinkChange, ...] = ()
    strands: tuple[StrandRow, ...] = ()
    paths: dict[str, list[tuple[float, float]]] = {}
    """By epoch: all corners of the strand's path; arc length counts from the first."""
    start: Start | None = None
    steps: tuple[StepRow, ...] = ()
    losses: Losses | None = None
    books: tuple[Book, ...] = ()
    end_s: float | None = None
    """The newest time of the run so far."""
    ended: bool = False
    """Nothing more will come."""
    verdict: dict[str, Any] | None = None
    """`verdict.json` as it stands there."""
    shortfall: str = ""
    """Of a law that promises no clearance: what the least clearance is short of, in a sentence."""
    flaws: tuple[str, ...] = ()
    """All that is known to be wrong with the log, in sentences."""
