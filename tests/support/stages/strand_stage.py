"""A strand of three robots in a row, and their messages to each other."""

from agents.strand.forming import lined_up

from agents.commands import Command, Note, Tell
from agents.strand.strand import Own, Strand
from protocol.frames import Point, Pose, Vertex
from protocol.mission import Law
from protocol.timeline import AuthorityGranted
from protocol.wire.messages import AheadState, BehindState, Handover, Reversal
from tests.support.stages.one_step import under

MISSION = under(Law.CERTIFIED, robots=3, robot_radius_m=0.1, separation_m=0.1)
KEEP_M = 0.31  # two radii, the separation and the tolerance
ORDER = (3, 2, 1)
PLACES = {robot: Pose(x_m=float(robot), y_m=0.0, heading_rad=0.0) for robot in ORDER}
KNOWN = len(lined_up(1, ORDER, PLACES, MISSION, 0.0).path)  # vertices that all robots know from the start
NOTHING_HANDED = Handover(number=0, steps=0, dissolved=0, seen=b"")
HEARTBEAT_S, SILENCE_S = MISSION.heartbeat_s, MISSION.silence_s


def place(robot: int) -> Strand:
    return lined_up(robot, ORDER, PLACES, MISSION, 0.0)


def leading() -> Strand:
    """The leader's place, with a step of four metres ahead of it."""
    strand = place(3)
    strand.path.extend(Point(x_m=7.0, y_m=0.0))
    return strand


def own(
    progress_m: float, *, stands: bool = True, arrived: bool = False, handed: Handover = NOTHING_HANDED
) -> Own:
    return Own(progress_m, Pose(x_m=1.0 + progress_m, y_m=0.0, heading_rad=0.0), stands, arrived, handed)


def ahead(
    *,
    epoch: int = 1,
    echo_s: float = 0.0,
    path_from: int = KNOWN,
    path: tuple[Vertex, ...] = (),
    authority_m: float = 0.0,
    progress_m: float = 2.0,
    reversal: Reversal | None = None,
) -> AheadState:
    """What a robot hears from the one ahead."""
    return AheadState(
        epoch=epoch,
        echo_s=echo_s,
        path_from=path_from,
        path=path,
        progress_m=progress_m,
        authority_m=authority_m,
        pose=PLACES[3],
        arrived=False,
        lineage=(),
        vertices=path_from + len(path),
        backs_up=False,
        reversal=reversal,
    )


def behind(
    *,
    epoch: int = 1,
    echo_s: float = 0.0,
    vertices: int = KNOWN,
    progress_m: float = 0.0,
    tail_m: float = 0.0,
    stand: bool = True,
    handed: int = 0,
) -> BehindState:
    """What a robot hears from the one behind."""
    return BehindState(
        epoch=epoch,
        echo_s=echo_s,
        handed=handed,
        vertices=vertices,
        progress_m=progress_m,
        tail_progress_m=tail_m,
        stand=stand,
        pose=PLACES[2],
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
