"""Draws the figures of a folder with a run or a campaign, and writes the files."""

from collections.abc import Sequence
from pathlib import Path

from clew.campaign.campaign import CAMPAIGN_FILE
from clew.figures import campaign as of_campaign
from clew.figures import run as of_run
from clew.figures.bare import stand_in
from clew.figures.outcomes import read_campaign
from clew.figures.style import Chart, LeftOut, render
from clew.log import timeline
from clew.log.log import check_one_fleet
from clew.story.course import course_of
from protocol.errors import UsageError
from protocol.files.writing import make_folder, write_whole
from world.record.recorder import EVENTS_FILE

Charts = Sequence[Chart | LeftOut]


def charts_in(source: Path) -> tuple[Charts, tuple[str, ...]]:
    """The figures of a run or a campaign, given its folder or file, and the flaws of its data.

    Raises:
        UsageError: it is neither, has several fleets, or cannot be read.
    """
    if not source.exists():
        raise UsageError(f"{source}: there is no such run or campaign")
    check_one_fleet(source)
    path = source / (EVENTS_FILE if (source / EVENTS_FILE).exists() else CAMPAIGN_FILE)
    if not source.is_dir():
        path = source
    if path.suffix == ".json":
        outcomes, flaws = read_campaign(path)
        return of_campaign.charts_of(outcomes), flaws
    read = timeline.read(path)
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
        UsageError: a file cannot be written.
    """
    written = []
    try:
        if not out.is_dir():
            make_folder(out)
        for chart in charts:
            if isinstance(chart, Chart):
                for form, drawn in render(chart, formats).items():
                    path = out / f"{chart.name}.{form}"
                    write_whole(path, drawn)
                    written.append(path)
    except OSError as error:
        raise UsageError(f"cannot write figures into {out}: {error.strerror or error}") from error
    return written
