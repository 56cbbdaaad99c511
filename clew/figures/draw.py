"""Draws the figures of a run or a campaign, and writes the files."""

from collections.abc import Sequence
from itertools import product
from pathlib import Path

from clew.figures import campaign as of_campaign
from clew.figures import run as of_run
from clew.figures.bare import stand_in
from clew.figures.outcomes import Read
from clew.figures.style import MARK, Chart, LeftOut, render
from clew.log.timeline import Timeline
from clew.story.course import course_of
from protocol.errors import UsageError
from protocol.files.writing import check_ours, make_folder, write_whole

Charts = Sequence[Chart | LeftOut]


def charts_of(read: Timeline | Read) -> tuple[Charts, tuple[str, ...]]:
    """The figures of a run or a campaign, and the flaws of its data.

    Raises:
        UsageError: the run's log does not say enough to draw it.
    """
    if not isinstance(read, Timeline):
        outcomes, flaws = read
        return of_campaign.charts_of(outcomes), flaws
    try:
        return of_run.charts_of(course_of(read)), read.flaws
    except UsageError as error:
        scenario = stand_in(read)
        if scenario is None:
            raise
        flaws = (*read.flaws, str(error))
    return of_run.charts_without_scenario(course_of(read, scenario)), flaws


def write(charts: Charts, out: Path, formats: tuple[str, ...]) -> list[Path]:
    """Write every figure that can be drawn in each of these formats.

    Raises:
        UsageError: a file cannot be written, or would replace one that is not ours.
    """
    drawn_charts = [chart for chart in charts if isinstance(chart, Chart)]
    for chart, form in product(drawn_charts, formats):
        check_ours(out / f"{chart.name}.{form}", MARK.encode())
    written = []
    try:
        if not out.is_dir():
            make_folder(out)
        for chart in drawn_charts:
            for form, drawn in render(chart, formats).items():
                path = out / f"{chart.name}.{form}"
                write_whole(path, drawn)
                written.append(path)
    except OSError as error:
        raise UsageError(f"cannot write figures into {out}: {error.strerror or error}") from error
    return written
