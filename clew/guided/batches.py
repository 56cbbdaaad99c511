"""Searches many seeds, batch by batch. All seeds of a batch know the cells of the batches before.

Rule 1: what a batch knows does not depend on which of its seeds ends first, nor on how many processes there
        are. So a guided campaign is the same every time, as long as none of it is left out.
"""

from collections.abc import Iterator, Sequence
from functools import partial

from clew.campaign.episode import Episode, Outcome
from clew.campaign.executors.pool import results_of
from clew.guided.corpus import Corpus
from clew.guided.search import Found, Limits, lost, search

BATCH = 8  # seeds; enough for the processes of most machines, and a small part of any campaign


def guided_outcomes(
    episodes: Sequence[Episode], jobs: int, limits: Limits | None = None
) -> Iterator[Outcome]:
    """The outcomes of searches, in the order in which they come within each batch."""
    known = Corpus()
    for first in range(0, len(episodes), BATCH):
        batch, found = episodes[first : first + BATCH], dict[str, Found]()
        play = partial(search, known=known, limits=limits or Limits())
        for each in results_of(batch, jobs, play, lost):
            found[each.outcome.key] = each
            yield each.outcome
        for episode in batch:
            known.merge(found[episode.key].visits)
