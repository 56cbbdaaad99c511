"""A strand of three robots in a row, as a formation tells it, and their messages to each other."""

from collections.abc import Mapping, Sequence

from agents.commands import Command, Note, Tell
from agents.strand.news import Own
from agents.strand.strand import Strand
from protocol.fence import Epoch, Fence, May
from protocol.frames import Point, Pose, Vertex
from protocol.path import Path, straightened
from protocol.timeline import AuthorityGranted
from protocol.wire.messages import AheadState, BehindState, Handover
from protocol.wire.view import Counters, Formation, Neighbour
from tests.support.stages.one_step import under

MISSION = under("certified", robots=3, robot_radius_m=0.1, separation_m=0.1)
KEEP_M = 0.31  # two radii, the separation and the tolerance
ORDER = (3, 2, 1)
PLACES = {robot: Pose(x_m=float(robot), y_m=0.0, heading_rad=0.0) for robot in ORDER}
EPOCH = Epoch(generation=1, robot=3, life=1003)
TURN = 1
KNOWN = 2  # vertices that all robots know from the start: a straight queue is one segment
NOTHING_HANDED = Handover(number=0, steps=0, seen=b"")
HEARTBEAT_S, SILENCE_S = MISSION.heartbeat_s, MISSION.silence_s


def life_of(robot: int) -> int:
    """The life of a robot in its first formation."""
    return 1000 + robot


def fence_all(epoch: Epoch = EPOCH, *, leader: int = ORDER[0], members: int = 3) -> Fence:
    """The fence under which a formation may drive."""
    return Fence(epoch=epoch, turn=TURN, may=May.ALL, robot=leader, members=members)


def queue_path(order: Sequence[int], places: Mapping[int, Pose]) -> Path:
    """The path of robots that have lined up: straight from the tail over all places to the leader's."""
    return Path(straightened([Point(x_m=places[each].x_m, y_m=places[each].y_m) for each in reversed(order)]))


def formation(
    robot: int,
    order: Sequence[int],
    places: Mapping[int, Pose],
    places_m: Mapping[int, float],
    path: Path,
    *,
    epoch: Epoch = EPOCH,
    driven: bool = False,
    back_by_m: float = 0.0,
    counters: Counters = Counters(),  # noqa: B008 - it is frozen
    heals: bool = False,
) -> Formation:
    """What the coordinator tells one member, in one piece."""
    rank = list(order).index(robot)

    def neighbour(at: int) -> Neighbour | None:
        if not 0 <= at < len(order):
            return None
        return Neighbour(robot=order[at], life=life_of(order[at]), s_m=places_m[order[at]])

    return Formation(
        epoch=epoch,
        life=life_of(robot),
        turn=TURN,
        members=len(order),
        rank=rank,
        s_m=places_m[robot],
        place=places[robot],
        ahead=neighbour(rank - 1),
        behind=neighbour(rank + 1),
        leg_is_driven=driven,
        back_by_m=back_by_m,
        counters=counters,
        heals=heals,
        led_by=0,
        first=0,
        vertices=len(path),
        path=tuple(path),
    )


def queued(robot: int, order: Sequence[int] = ORDER, *, back_by_m: float = 0.0) -> Formation:
    """The formation of robots that stand in a row, the tail at arc length 0."""
    path = queue_path(order, PLACES)
    zero = PLACES[order[-1]].x_m
    places_m = {each: abs(PLACES[each].x_m - zero) for each in order}
    return formation(robot, order, PLACES, places_m, path, back_by_m=back_by_m)


def place(robot: int, order: Sequence[int] = ORDER, *, back_by_m: float = 0.0) -> Strand:
    told = queued(robot, order, back_by_m=back_by_m)
    return Strand(robot, told, queue_path(order, PLACES), MISSION, 0.0)


def leading() -> Strand:
    """The leader's place, with a step of four metres ahead of it."""
    strand = place(3)
    strand.path.extend(Point(x_m=7.0, y_m=0.0))
    return strand


def own(
    progress_m: float, *, stands: bool = True, arrived: bool = False, handed: Handover = NOTHING_HANDED
) -> Own:
    return Own(progress_m, stands, arrived, handed)


def ahead(
    *,
    epoch: Epoch = EPOCH,
    life: int | None = None,
    t_s: float = 0.0,
    path_from: int = KNOWN,
    path: tuple[Vertex, ...] = (),
    authority_m: float = 0.0,
    progress_m: float = 2.0,
    backs_up: bool = False,
) -> AheadState:
    """What robot 2 hears from the one ahead."""
    return AheadState(
        epoch=epoch,
        life=life_of(3) if life is None else life,
        t_s=t_s,
        path_from=path_from,
        path=path,
        progress_m=progress_m,
        authority_m=authority_m,
        arrived=False,
        vertices=path_from + len(path),
        backs_up=backs_up,
        handed=None,
    )


def behind(
    robot: int = 2,
    *,
    epoch: Epoch = EPOCH,
    life: int | None = None,
    t_s: float = 0.0,
    vertices: int = KNOWN,
    progress_m: float | None = None,
    tail_m: float = 0.0,
    stand: bool = True,
    handed: int = 0,
) -> BehindState:
    """What a robot hears from the one behind."""
    return BehindState(
        epoch=epoch,
        life=life_of(robot) if life is None else life,
        t_s=t_s,
        handed=handed,
        vertices=vertices,
        progress_m=PLACES[robot].x_m - 1.0 if progress_m is None else progress_m,
        tail_progress_m=tail_m,
        stand=stand,
    )


def told(commands: list[Command], robot: int) -> AheadState | BehindState:
    (state,) = (command.state for command in commands if isinstance(command, Tell) and command.robot == robot)
    return state


def told_behind(commands: list[Command], robot: int) -> AheadState:
    state = told(commands, robot)
    assert isinstance(state, AheadState)
    return state


def told_ahead(commands: list[Command], robot: int) -> BehindState:
    state = told(commands, robot)
    assert isinstance(state, BehindState)
    return state


def granted(commands: list[Command]) -> list[float]:
    records = [command.record for command in commands if isinstance(command, Note)]
    return [record.authority_m for record in records if isinstance(record, AuthorityGranted)]
