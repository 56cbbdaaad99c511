"""Objects that go on from event to event, as numbers. They are compared only where that is asked for.

To compare an object costs more than a step of it, and schedules hardly ever meet within a moment. So a number
stands for a content (0 and more) or for the events after a content (less than 0), until it is settled.

Rule 1: an object with one content goes on in the same way after the same event. So the events say it all.
Rule 2: what is not kept any more is computed again, from the content before it.
"""

from collections import OrderedDict
from collections.abc import Callable, Collection
from typing import Generic, TypeVar

from clew.explore.store import Snapshots

T = TypeVar("T")
E = TypeVar("E")

AT_HAND_MAX = 2000  # objects that are kept as such, about 30 kB each: most are needed once more, soon


class Trails(Generic[T, E]):
    """All objects of one kind."""

    def __init__(self, contents: Snapshots[T], go_on: Callable[[T, E], object]) -> None:
        """`go_on` lets an object process an event."""
        self._contents = contents
        self._go_on = go_on
        self._after: dict[int, tuple[int, E]] = {}
        self._settled: dict[int, int] = {}
        self._at_hand: OrderedDict[int, T] = OrderedDict()
        self._count = 0

    def __len__(self) -> int:
        return len(self._contents) + len(self._after)

    def add(self, thing: T) -> int:
        """The number of an object's content. The caller changes it no more."""
        number = self._contents.add(thing)
        self._keep(number, thing)
        return number

    def load(self, number: int) -> T:
        """The object, or a copy of it, for the caller to change."""
        events: list[E] = []
        while (thing := self._at_hand.pop(number, None)) is None and number < 0:
            number, event = self._after[number]
            events.append(event)
        thing = self._contents.load(number) if thing is None else thing
        for event in reversed(events):
            self._go_on(thing, event)
        return thing

    def follow(self, number: int, event: E, thing: T) -> int:
        """The number of an object that had this number and has processed this event."""
        self._count += 1
        self._after[-self._count] = (number, event)
        self._keep(-self._count, thing)
        return -self._count

    def settle(self, number: int) -> int:
        """The number of its content."""
        if number >= 0:
            return number
        settled = self._settled.get(number)
        if settled is None:
            settled = self._settled[number] = self.add(self.load(number))
        return settled

    def keep_only(self, numbers: Collection[int]) -> None:
        """Forget all but these, and what they go on from."""
        after: dict[int, tuple[int, E]] = {}
        contents: set[int] = set()
        for number in numbers:
            each = number
            while each < 0 and each not in after:
                after[each] = self._after[each]
                each = after[each][0]
            if each >= 0:
                contents.add(each)
        self._after = after
        self._settled = {}
        self._contents.keep_only(contents)
        for number in [each for each in self._at_hand if each not in after and each not in contents]:
            del self._at_hand[number]

    def _keep(self, number: int, thing: T) -> None:
        self._at_hand[number] = thing
        if len(self._at_hand) > AT_HAND_MAX:
            self._at_hand.popitem(last=False)
