"""One instant of a run: where everybody was, what everybody did, and who led. Pure."""

from collections import defaultdict
from collections.abc import Sequence
from dataclasses import dataclass

from clew.story.story import story_of
from protocol.timeline import FenceChanged, PoseSampled
from world.judge.truth.track import Track
from world.record.lines import Line


@dataclass(frozen=True, slots=True, kw_only=True)
class RobotThen:
    """A robot at an instant."""

    robot: int
    x_m: float | None
    """[world frame]; None: its body had not been placed."""
    y_m: float | None
    heading_rad: float | None
    """As last sampled."""
    clearance_m: float | None
    separation_m: float | None
    state: str
    """What it did: `leading`, `following`, `killed`, ... (`clew.story.states`)."""
    place: int | None
    """In the strand; the leader's is 0."""
    silent: tuple[int, ...]
    """The neighbours that it did not hear."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Moment:
    """An instant of a run."""

    t_s: float
    robots: dict[int, RobotThen]
    order: tuple[int, ...]
    """The strand, leader first; empty before the first has formed."""
    step: int
    """The newest switching step that was planned."""
    epoch: int
    """Of the fence; 0 before the first."""
    may_move: str
    """Whom the fence let move."""

    @property
    def leader(self) -> int | None:
        """The robot that led, if there was a strand."""
        return self.order[0] if self.order else None


def moment_of(lines: Sequence[Line], t_s: float) -> Moment:
    """The instant, by all entries of up to then; between two samples a body moved straight."""
    story = story_of(line for line in lines if line[1].t_s <= t_s)
    tracks = defaultdict[int, Track](Track)
    epoch, may_move = 0, ""
    newest: dict[int, PoseSampled] = {}
    for _, entry in lines:
        if isinstance(entry.record, PoseSampled):
            tracks[entry.record.robot].hear(entry.t_s, entry.record)
        if entry.t_s > t_s:
            continue
        match entry.record:
            case PoseSampled(robot=robot) as pose:
                newest[robot] = pose
            case FenceChanged(epoch=epoch, may=may):
                may_move = str(may)
            case _:
                pass  # the story has it
    robots: dict[int, RobotThen] = {}
    for robot in sorted({*newest, *story.robots.each}):
        told, sampled = story.robots.of(robot), newest.get(robot)
        here = None if sampled is None else tracks[robot].at(t_s)
        robots[robot] = RobotThen(
            robot=robot,
            x_m=None if here is None else here.x_m,
            y_m=None if here is None else here.y_m,
            heading_rad=None if sampled is None else sampled.heading_rad,
            clearance_m=None if sampled is None else sampled.clearance_m,
            separation_m=None if sampled is None else sampled.separation_m,
            state=told.state.word,
            place=told.place,
            silent=told.silent,
        )
    formed = [strand for strand in story.strands.formed.values() if strand.t_s <= t_s]
    order = max(formed, key=lambda strand: strand.t_s).formed.order if formed else ()
    return Moment(
        t_s=t_s, robots=robots, order=order, step=story.steps.newest, epoch=epoch, may_move=may_move
    )
