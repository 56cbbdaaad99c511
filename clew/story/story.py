"""The story of a run: what has happened, derived once from its entries. Pure; whole, or while it goes on.

    story = story_of(lines)                # in the recorder's order; or entry by entry, with `hear`
    story.robots.changes, story.steps.all(story.robots.changes), ...

The live table, the report page, figures and exports read what it holds; what each of its parts means, and by
which rules, stands in the part's file. Entries of one source come in their order, sources in any.
"""

from collections.abc import Iterable
from dataclasses import dataclass, field

from clew.story import links, losses, states, steps, strands
from clew.story.links import Links
from clew.story.losses import Losses
from clew.story.robots import Robots
from clew.story.steps import Step, Steps
from clew.story.strands import Strands
from protocol.timeline import Entry, FaultInjected, PoseSampled
from world.record.lines import Line


@dataclass(slots=True)
class Story:
    """What has happened so far."""

    robots: Robots = field(default_factory=Robots)
    links: Links = field(default_factory=Links)
    strands: Strands = field(default_factory=Strands)
    steps: Steps = field(default_factory=Steps)
    losses: Losses = field(default_factory=Losses)
    poses: dict[int, tuple[float, PoseSampled]] = field(default_factory=dict)
    """The newest of each body, and when it was."""
    end_s: float = 0.0
    """The greatest time of an entry."""
    count: int = 0
    """How many entries have been heard."""

    def hear(self, source: str, entry: Entry) -> None:
        """Take an entry in."""
        self.count += 1
        self.end_s = max(self.end_s, entry.t_s)
        if isinstance(entry.record, PoseSampled):
            self._see(entry.t_s, entry.record)
            return
        kind = type(entry.record)
        if isinstance(entry.record, FaultInjected) and entry.record.process is None:
            self.losses.hear(source, entry)
            return
        if kind in states.KINDS:
            self.robots.hear(source, entry)
        if kind in links.KINDS:
            self.links.hear(source, entry)
        if kind in strands.KINDS:
            self.strands.hear(source, entry)
        if kind in steps.KINDS:
            self.steps.hear(source, entry)
        if kind in losses.KINDS:
            self.losses.hear(source, entry)

    def _see(self, t_s: float, pose: PoseSampled) -> None:
        before = self.poses.get(pose.robot)
        self.poses[pose.robot] = t_s, pose
        if before is not None and (before[1].x_m, before[1].y_m) != (pose.x_m, pose.y_m):
            self.robots.move(t_s, pose.robot)

    def all_steps(self) -> tuple[Step, ...]:
        """The switching steps so far, in the order of their times."""
        return self.steps.all(self.robots.changes)


def story_of(lines: Iterable[Line]) -> Story:
    """The story of these entries."""
    story = Story()
    for source, entry in lines:
        story.hear(source, entry)
    return story
