"""The state of a robot's core at one moment, by names: `clew replay --until` shows it, `--break` asks for it.

None: there is no such thing now, as an epoch before the first odometry, or a place outside a strand.
"""

from collections.abc import Iterable

from msgspec import Struct
from msgspec.structs import asdict

from agents.coordinating.draft import Drafted
from agents.process.journal import Input
from agents.robot import Robot
from protocol.keys import robot_name

Value = float | int | str | bool | None


class CoreState(Struct, frozen=True, kw_only=True):
    """A core after an input; docs/replay.md says what each name means."""

    # the input
    t_s: float
    robot: int
    input: int
    event: str
    key: str
    number: int
    # its part in views
    awake: bool
    state: str
    coordinates: bool
    phase: str | None
    awaits: str | None
    awaits_s: float | None
    epoch: int
    generation: int
    turn: int
    may: str
    named: int
    draft: str | None
    in_place: str | None
    left_out: str | None
    # its place in the strand
    leads: bool
    rank: int | None
    members: int | None
    step: int | None
    progress_m: float | None
    authority_m: float | None
    granted_m: float | None
    path_m: float | None
    holds: bool
    arrived: bool
    reason: str | None
    # its neighbours
    ahead: int | None
    ahead_m: float | None
    ahead_silent_s: float | None
    behind: int | None
    behind_m: float | None
    behind_silent_s: float | None
    # its body
    x_m: float | None
    y_m: float | None
    heading_rad: float | None
    moving: bool
    finished: int | None
    order: int
    target_x_m: float | None
    target_y_m: float | None


NAMES = CoreState.__struct_fields__
GROUPS = {
    "view": "state",
    "strand": "leads",
    "links": "ahead",
    "body": "x_m",
}
"""The lines of a state as text, each with its first name; it has all names up to the next line's."""


def state_of(core: Robot, count: int, heard: Input, robot: int) -> CoreState:
    """The state of a robot's core after an input, which is the count-th of its process."""
    member, odometry, target, fence = core.member, core.odometry, core.order.target, core.fence
    formation = None if member is None else member.formation
    ahead = None if formation is None or formation.ahead is None else formation.ahead.robot
    behind = None if formation is None or formation.behind is None else formation.behind.robot
    links = {link.neighbour: link for link in core.links}
    drafted = core.drafted(heard.now_s)
    told_m = {robot: None if link.state is None else link.state.progress_m for robot, link in links.items()}
    silent_s = {robot: link.silent_s(heard.now_s) for robot, link in links.items()}
    return CoreState(
        t_s=heard.now_s,
        robot=robot,
        input=count,
        event=heard.kind,
        key=heard.key,
        number=heard.number,
        awake=core.awake,
        state=str(core.state),
        coordinates=core.coordinates,
        phase=None if core.phase is None else str(core.phase),
        awaits=None if drafted is None else names(sorted(drafted.awaited)),
        awaits_s=None if drafted is None else heard.now_s - drafted.since_s,
        epoch=fence.epoch.number,
        generation=fence.epoch.generation,
        turn=fence.turn,
        may=str(fence.may),
        named=fence.robot,
        draft=None if drafted is None else names(drafted.order),
        in_place=None if drafted is None else names(drafted.in_place),
        left_out=None if drafted is None else left_out(drafted),
        leads=core.leads,
        rank=None if formation is None else formation.rank,
        members=None if formation is None else formation.members,
        step=None if member is None else member.counters.steps,
        progress_m=None if member is None else member.progress_m,
        authority_m=None if member is None else member.strand.authority_m,
        granted_m=None if member is None else member.strand.grants.granted_m,
        path_m=None if member is None else member.path.end_m,
        holds=member is not None and member.holds,
        arrived=member is not None and member.arrived,
        reason=None if member is None or member.reason is None else str(member.reason.cause),
        ahead=ahead,
        ahead_m=told_m.get(ahead or 0),
        ahead_silent_s=silent_s.get(ahead or 0),
        behind=behind,
        behind_m=told_m.get(behind or 0),
        behind_silent_s=silent_s.get(behind or 0),
        x_m=None if odometry is None else odometry.pose.x_m,
        y_m=None if odometry is None else odometry.pose.y_m,
        heading_rad=None if odometry is None else odometry.pose.heading_rad,
        moving=odometry is not None and odometry.moving,
        finished=None if odometry is None else odometry.finished,
        order=core.order.number,
        target_x_m=None if target is None else target.x_m,
        target_y_m=None if target is None else target.y_m,
    )


def left_out(drafted: Drafted) -> str:
    """Why robots have no place in a draft, in a few words."""
    return "; ".join(f"{robot_name(robot)}: {why}" for robot, why in drafted.left_out.items()) or "nobody"


def names(robots: Iterable[int]) -> str:
    """Robots, in order."""
    return " ".join(map(robot_name, robots)) or "nobody"


def lines_of(state: CoreState) -> list[str]:
    """A state for people: a line for each group, with the names as expressions use them."""
    lines: list[str] = []
    first = {name: title for title, name in GROUPS.items()}
    values: dict[str, Value] = asdict(state)
    for name in NAMES[NAMES.index("awake") :]:
        if name == "awake":
            lines.append(f"  {'core':<7}")
        elif name in first:
            lines.append(f"  {first[name]:<7}")
        if name in first or values[name] is not None:
            lines[-1] += f" {name}={_short(values[name])}"
    return lines


def headline(state: CoreState, incarnation: str) -> str:
    """Whose state it is, and after which input."""
    number = f" {state.number}" if state.number else ""
    return (
        f"{robot_name(state.robot)} ({incarnation}) at t={state.t_s:.3f} s, after input {state.input}: "
        f"{state.event}, message{number} on {state.key}"
    )


def _short(value: Value) -> str:
    match value:
        case None:
            return "none"
        case bool():
            return "yes" if value else "no"
        case float():
            return f"{value:.3f}"
        case _:
            return str(value)
