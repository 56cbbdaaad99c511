"""What a timeline tells of a strand that forms, for tests that begin with one."""

from protocol.fence import NUMBERS, Cause, May
from protocol.frames import Point
from protocol.timeline import FenceChanged, OrderAccepted, Record, StrandFormed, StrandJoined

ALL_TURN = 1  # nobody had to move
Told = tuple[str, Record]


def raised(epoch: int, cause: Cause = Cause.START) -> Told:
    """The fence of a view that has been proposed."""
    fence = FenceChanged(
        epoch=epoch, turn=0, may=May.NOBODY, coordinator=epoch % NUMBERS, life="a", cause=cause
    )
    return "world", fence


def turn(epoch: int, number: int, robot: int | None = None) -> Told:
    """A turn lease; None: it is taken back."""
    may = May.NOBODY if robot is None else May.ONE
    fence = FenceChanged(
        epoch=epoch, turn=number, may=may, coordinator=epoch % NUMBERS, life="a", named=robot or 0
    )
    return "world", fence


def driving(epoch: int, *order: int, number: int = ALL_TURN) -> Told:
    """The fence under which a strand drives."""
    fence = FenceChanged(
        epoch=epoch,
        turn=number,
        may=May.ALL,
        coordinator=epoch % NUMBERS,
        life="a",
        named=order[0],
        members=len(order),
    )
    return "world", fence


def formed(epoch: int, *order: int, back_by_m: float = 0.0) -> StrandFormed:
    """Robots a metre apart on the x axis, the leader at the right."""
    count = len(order)
    return StrandFormed(
        epoch=epoch,
        turn=ALL_TURN,
        order=order,
        lives=("a",) * count,
        places_m=tuple(float(count - 1 - rank) for rank in range(count)),
        laid=tuple(Point(x_m=float(place), y_m=0.0) for place in range(count)),
        driven=(True,) * count,
        back_by_m=back_by_m,
        sensed=False,
    )


def strand(epoch: int, *order: int, back_by_m: float = 0.0) -> tuple[Told, ...]:
    """A view in which a strand forms, by its first robot's word, and drives."""
    return (
        raised(epoch),
        (f"r{order[0]}", formed(epoch, *order, back_by_m=back_by_m)),
        driving(epoch, *order),
        *((f"r{robot}", StrandJoined(epoch=epoch, rank=rank)) for rank, robot in enumerate(order)),
    )


def ordered(
    robot: int,
    *,
    epoch: int,
    number: int = 1,
    turn: int = ALL_TURN,
    step: int = 0,
    x_m: float = 0.0,
    y_m: float = 0.0,
    target: Point | None = None,
    reach_m: float = 0.0,
) -> OrderAccepted:
    """An order that a body has accepted."""
    return OrderAccepted(
        robot=robot,
        number=number,
        epoch=epoch,
        turn=turn,
        life="a",
        step=step,
        x_m=x_m,
        y_m=y_m,
        target=target,
        reach_m=reach_m,
    )
