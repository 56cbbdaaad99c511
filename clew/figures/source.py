"""Reads what figures are drawn of, a run or a campaign. It needs no library that draws."""

from pathlib import Path

from clew.campaign.campaign import CAMPAIGN_FILE
from clew.figures.outcomes import Read, read_campaign
from clew.log import timeline
from clew.log.log import check_run_or_campaign
from world.record.recorder import EVENTS_FILE


def read_source(source: Path) -> timeline.Timeline | Read:
    """The timeline of a run, or the outcomes of a campaign, given its folder or file.

    Raises:
        UsageError: it is neither, has several fleets, or cannot be read.
    """
    check_run_or_campaign(source)
    path = source / (EVENTS_FILE if (source / EVENTS_FILE).exists() else CAMPAIGN_FILE)
    if not source.is_dir():
        path = source
    return read_campaign(path) if path.suffix == ".json" else timeline.read(path)
