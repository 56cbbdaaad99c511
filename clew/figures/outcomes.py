"""The outcomes of a campaign for its figures: everything that can be read.

Rule 1: an unreadable episode is a flaw; the others are drawn.
Rule 2: if `campaign.json` is unreadable or missing, `episodes.jsonl` beside it has the same data.
"""

from pathlib import Path

import msgspec
from msgspec import Struct

from clew.campaign.campaign import CAMPAIGN_FILE, EPISODES_FILE, read_outcomes
from clew.campaign.episode import Outcome
from protocol.errors import UsageError
from protocol.files.opening import MADE_BYTES_MAX, read_bytes
from world.record.recorder import EVENTS_FILE

Read = tuple[tuple[Outcome, ...], tuple[str, ...]]
"""Outcomes, and the flaws of their file."""


class _Campaign(Struct, frozen=True):
    """The required fields of `campaign.json`."""

    episodes: tuple[msgspec.Raw, ...]


def read_campaign(path: Path) -> Read:
    """The outcomes in a campaign's `campaign.json`.

    Raises:
        UsageError: there is neither that nor an `episodes.jsonl`.
    """
    try:
        said = msgspec.json.decode(read_bytes(path, MADE_BYTES_MAX), type=_Campaign)
    except FileNotFoundError as error:
        said_of_it = f"{path.parent}: neither a run ({EVENTS_FILE}) nor a campaign ({CAMPAIGN_FILE})"
        return _from_episodes(path, f"there is no {CAMPAIGN_FILE}", UsageError(said_of_it), error)
    except OSError as error:
        raise UsageError(f"{path}: cannot be read: {error.strerror}") from error
    except (msgspec.MsgspecError, ValueError) as error:
        refusal = UsageError(f"{path}: no campaign that this program can read: {error}")
        return _from_episodes(path, f"{path.name} cannot be read: {error}", refusal, error)
    return _outcomes(said)


def _outcomes(said: _Campaign) -> Read:
    outcomes: list[Outcome] = []
    flaws: list[str] = []
    for number, raw in enumerate(said.episodes, start=1):
        try:
            outcomes.append(msgspec.json.decode(raw, type=Outcome))
        except (msgspec.MsgspecError, ValueError) as error:
            flaws.append(f"episode {number} cannot be read: {error}")
    return tuple(outcomes), tuple(flaws)


def _from_episodes(path: Path, flaw: str, refusal: UsageError, cause: Exception) -> Read:
    """Rule 2: the outcomes in `episodes.jsonl`.

    Raises:
        UsageError: the refusal, if there are no episodes.
    """
    try:
        outcomes = tuple(read_outcomes(path.with_name(EPISODES_FILE)).values())
    except OSError:
        outcomes = ()
    if not outcomes:
        raise refusal from cause
    return outcomes, (f"{flaw}: drawn from {EPISODES_FILE}",)
