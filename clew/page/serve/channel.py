"""One watched run: reads its news, packs them and wakes the pages that wait for them."""

import asyncio
import contextlib
import secrets
from collections.abc import AsyncIterator, Iterator
from dataclasses import dataclass, field
from typing import assert_never

from clew.log.follow import LOOK_S, News
from clew.page.batches import Batches
from clew.page.serve.feed import Feed, Place
from clew.page.serve.watch import Began, Over, Watch
from clew.page.telling import folder_of


@dataclass(slots=True)
class Channel:
    """The news of one run, for its pages."""

    watch: Watch
    feed: Feed = field(default_factory=Feed)
    _batches: Batches | None = None
    _folder: str = ""
    _news: asyncio.Event = field(default_factory=asyncio.Event)
    _over: bool = False

    async def follow(self, closing: asyncio.Event) -> None:
        """Read and publish news; on closing, everything written so far is still published."""
        while True:
            last = closing.is_set()
            # In a thread: packing a long log takes seconds, and pages need answers meanwhile.
            seen = await asyncio.to_thread(lambda: list(self._look()))
            for said in seen:
                self._tell(said)
            if not seen:
                if last:
                    break
                with contextlib.suppress(TimeoutError):
                    await asyncio.wait_for(closing.wait(), LOOK_S)
        self._over = True
        self._wake()

    def _look(self) -> Iterator[Began | bytes]:
        """The packed news of one look."""
        for seen in self.watch.look():
            match seen:
                case Began():
                    self._batches, self._folder = None, folder_of(seen.events)
                    yield seen
                case News():
                    yield from self._packed(seen)
                case Over():
                    batches = self._batches or Batches(None)
                    batches.add(verdict=seen.verdict, flaws=seen.flaws)
                    yield from filter(None, [batches.batch(ended=True)])
                case _:
                    assert_never(seen)

    def _packed(self, news: News) -> Iterator[bytes]:
        if self._batches is None:
            self._batches = Batches(news.header, self._folder)
        for source, entry in news.lines:
            self._batches.hear(source, entry)
        if news.flaws:
            self._batches.add(flaws=news.flaws)
        yield from filter(None, [self._batches.batch()])

    def _tell(self, said: Began | bytes) -> None:
        if isinstance(said, Began):
            self.feed.begin(secrets.token_hex(4))
        else:
            self.feed.tell(said)
        self._wake()

    def _wake(self) -> None:
        self._news.set()
        self._news = asyncio.Event()

    async def messages(self, place: Place) -> AsyncIterator[bytes]:
        """The messages of a page from a place on, as they come, until we are closed."""
        while True:
            news = self._news  # read before we ask: later news wake us
            while (told := self.feed.next(place)) is not None:
                message, place = told
                yield message
            if self._over:
                return
            await news.wait()
