"""Tracks which part of a story has been sent to the page, and gives the rest. Pure."""

from collections.abc import Iterator

from clew.page.batch import Lane, Losses, StepRow, StrandRow
from clew.page.columns import DECIMALS, MS, column
from clew.story.links import LinkChange
from clew.story.losses import Book
from clew.story.states import State
from clew.story.steps import Place
from clew.story.story import Story

LANES = {
    State.FAILED: "dead",
    State.DEAD: "dead",
    State.KILLED: "dead",
    State.FROZEN: "dead",
    State.WAITING: "waiting",
    State.BLOCKED: "lining up",
    State.JOINING: "lining up",
    State.BOUND: "lining up",
    State.ASIDE: "aside",
    State.STRANDED: "aside",
    State.HOLDING: "holding",
    State.ARRIVED: "arrived",
}
"""The lane text of a state; in all other states, the robot is free to drive."""


class Told:
    """The sent part of a story."""

    def __init__(self) -> None:
        self._start = False
        self._states, self._links, self._strands, self._taken, self._closed, self._laid = 0, 0, 0, 0, 0, 0
        self._lanes: dict[int, str] = {}
        self._steps: dict[int, StepRow] = {}
        self._paths: dict[str, list[tuple[float, float]]] = {}

    def start(self, story: Story) -> Place | None:
        """The leader's first place, as soon as it is known."""
        if self._start or story.steps.start is None:
            return None
        self._start = True
        return story.steps.start

    def lanes(self, story: Story) -> Iterator[Lane]:
        """Changes in the robots' reasons to wait."""
        changes = story.robots.changes
        for change in changes[self._states :]:
            state = LANES.get(change.doing, "free")
            if change.doing is not State.ABSENT and self._lanes.get(change.robot) != state:
                self._lanes[change.robot] = state
                yield Lane(robot=change.robot, t_s=change.t_s, state=state)
        self._states = len(changes)

    def links(self, story: Story) -> tuple[LinkChange, ...]:
        """Changes in the states of links."""
        new = tuple(story.links.changes[self._links :])
        self._links += len(new)
        return new

    def strands(self, story: Story) -> Iterator[StrandRow]:
        """New strands."""
        formed = list(story.strands.formed.items())
        for epoch, strand in formed[self._strands :]:
            yield StrandRow(t_s=strand.t_s, epoch=epoch, turn=strand.formed.turn, order=strand.formed.order)
        self._strands = len(formed)

    def paths(self, story: Story) -> dict[str, list[tuple[float, float]]]:
        """The corners of each changed path, by epoch."""
        if story.strands.laid_count == self._laid:
            return {}
        self._laid = story.strands.laid_count
        now = {
            str(epoch): [(round(corner.x_m, DECIMALS), round(corner.y_m, DECIMALS)) for corner in path]
            for epoch, path in story.strands.paths().items()
        }
        changed = {epoch: corners for epoch, corners in now.items() if self._paths.get(epoch) != corners}
        self._paths = now
        return changed

    def steps(self, rows: Iterator[StepRow]) -> tuple[StepRow, ...]:
        """The changed rows."""
        now = dict(enumerate(rows))
        changed = tuple(row for place, row in now.items() if row != self._steps.get(place))
        self._steps = now
        return changed

    def losses(self, story: Story) -> Losses | None:
        """The messages that faults have removed since the last call."""
        taken = story.losses.taken[self._taken :]
        self._taken += len(taken)
        if not taken:
            return None
        return Losses(
            t=column([t_s for t_s, _ in taken], MS),
            sender=[sender for _, (sender, _) in taken],
            receiver=[receiver for _, (_, receiver) in taken],
        )

    def books(self, story: Story) -> tuple[Book, ...]:
        """The message counts of all links, if there are new ones."""
        if story.losses.closed == self._closed:
            return ()
        self._closed = story.losses.closed
        return story.losses.books()
