"""One watched run: looks, packs what it has seen, and wakes the pages that are told of it."""

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
    """What is seen of one run, and told."""

    watch: Watch
    feed: Feed = field(default_factory=Feed)
    _batches: Batches | None = None
    _folder: str = ""
    _news: asyncio.Event = field(default_factory=asyncio.Event)
    _over: bool = False

    async def follow(self, closing: asyncio.Event) -> None:
        """Look and tell, until all is told that there is when we are to close."""
        while True:
            last = closing.is_set()
            # In a thread: packing a long log takes seconds, in which pages have to be answered.
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
        """What one look brings, packed."""
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
        for heard in news.heard:
            self._batches.hear(heard.source, heard.entry)
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
        """What a page is told from a place on, as it comes, until we are closed."""
        while True:
            news = self._news  # before we ask: whatever comes after wakes us
            while (told := self.feed.next(place)) is not None:
                message, place = told
                yield message
            if self._over:
                return
            await news.wait()
