"""Draws what is in a folder, a run or a campaign, and writes the files."""

from collections.abc import Sequence
from pathlib import Path

import msgspec

from lab import timeline
from lab.campaign import CAMPAIGN_FILE, EPISODES_FILE, Campaign
from lab.figures import campaign as of_campaign
from lab.figures import run as of_run
from lab.figures.course import course_of
from lab.figures.style import Chart, LeftOut, render
from protocol.errors import UsageError
from world.recorder import EVENTS_FILE

Charts = Sequence[Chart | LeftOut]


def charts_in(source: Path) -> tuple[Charts, tuple[str, ...]]:
    """The figures of a run or a campaign, given its folder or its file, and what is wrong with what was read.

    Raises:
        UsageError: it is neither, or cannot be read.
    """
    if source.is_dir():
        if not (source / EVENTS_FILE).exists():
            return of_campaign.charts_of(read_campaign(source / CAMPAIGN_FILE)), ()
    elif source.suffix == ".json":
        return of_campaign.charts_of(read_campaign(source)), ()
    read = timeline.read(source)
    return of_run.charts_of(course_of(read)), read.flaws


def read_campaign(path: Path) -> Campaign:
    """A campaign's result.

    Raises:
        UsageError: there is none, or none that this version can read.
    """
    try:
        return msgspec.json.decode(path.read_bytes(), type=Campaign)
    except FileNotFoundError as error:
        raise UsageError(_nothing_in(path.parent)) from error
    except OSError as error:
        raise UsageError(f"{path}: {error.strerror}") from error
    except (msgspec.MsgspecError, ValueError) as error:
        raise UsageError(f"{path}: no campaign that this program can read: {error}") from error


def write(charts: Charts, out: Path, formats: tuple[str, ...]) -> list[Path]:
    """Write every figure that can be drawn, in each of these formats.

    Raises:
        UsageError: a file cannot be written.
    """
    written = []
    try:
        out.mkdir(parents=True, exist_ok=True)
        for chart in charts:
            if isinstance(chart, Chart):
                for form, drawn in render(chart, formats).items():
                    path = out / f"{chart.name}.{form}"
                    path.write_bytes(drawn)
                    written.append(path)
    except OSError as error:
        raise UsageError(f"cannot write figures into {out}: {error.strerror or error}") from error
    return written


def _nothing_in(folder: Path) -> str:
    if not folder.is_dir():
        return f"{folder}: there is no such folder"
    if (folder / EPISODES_FILE).exists():
        return f"{folder}: the campaign was killed before it wrote {CAMPAIGN_FILE}: the same command goes on"
    return f"{folder}: neither a run ({EVENTS_FILE}) nor a campaign ({CAMPAIGN_FILE})"
