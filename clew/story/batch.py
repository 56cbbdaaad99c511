"""The batch format: what the page is told of a run, whole in a report or piece by piece from a live one.

Rule 1: a run is a sequence of batches, and `clew.take(run_index, batch)` takes each in its order. The first
        has `subject`; a field that has nothing to say is left out.
Rule 2: no entry of the timeline is left out but pose.sampled, which is `tracks`. There a body goes straight
        and evenly from one place to the next, and is never further than `PLACE_TOLERANCE_M` from the log's.
Rule 3: a column is a list of whole numbers, each less the one before it; the first of a batch stands whole.
        Times are in ms, places in mm, angles in mrad, distances that are judged in 0.1 mm.
Rule 4: what replaces says so: `paths` by epoch, `verdict`, `flaws`. All else is added to what there is.
"""

from typing import Any

from msgspec import Struct

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


class LinkChange(Struct, frozen=True, kw_only=True):
    """A link from a time on; the lower of its two robots first."""

    one: int
    other: int
    t_s: float
    state: str
    """`up`, `silent` or `broken`, by what its two robots recorded."""


class Strand(Struct, frozen=True, kw_only=True):
    """The order of the strand from a time on, leader first."""

    t_s: float
    epoch: int
    order: tuple[int, ...]


class Position(Struct, frozen=True, kw_only=True):
    """Where the leader stood: a row of the step table. Row 0 is before the first step."""

    t_s: float
    robot: int
    step: int
    x_m: float
    y_m: float
    clearance_m: float | None
    """The least in the step that ended here; None: row 0, or no obstacle."""
    distances_m: tuple[float, ...]
    """To each obstacle of the scenario, from the centre, as in the paper's Table I; not rounded."""


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
    holds the source's name; then a list for each field of the kind. A place is a pair `[x, y]`."""
    lanes: tuple[Lane, ...] = ()
    links: tuple[LinkChange, ...] = ()
    strands: tuple[Strand, ...] = ()
    paths: dict[str, list[tuple[float, float]]] = {}
    """By epoch: all corners of the strand's path; arc length counts from the first."""
    positions: tuple[Position, ...] = ()
    end_s: float | None = None
    """The newest time of the run so far."""
    ended: bool = False
    """Nothing more will come."""
    verdict: dict[str, Any] | None = None
    """`verdict.json` as it stands there."""
    flaws: tuple[str, ...] = ()
    """All that is known to be wrong with the log, in sentences."""
