"""The properties that the rules promise, judged whenever a body obeys an order."""

from collections.abc import Collection, Iterator
from enum import StrEnum

from tests.model.state import Order, State
from tests.model.values import Formation, Kind, May, Named, Quality


class Property(StrEnum):
    """What the rules promise; the letters are those of the traces."""

    ONE_FENCE = "A: bodies that move together obey one fence"
    NAMED_MOVES = "B: only the robot that the fence names moves, or members under all"
    ONE_FORMATION = "C: one formation moves bodies in an epoch"
    PLACES_TRUE = "D: bodies stand where the formation says"
    SCAN_TRUE = "E: others stood when the scan was taken, and have not moved since"
    GROUND_LEFT = "F: a follower enters only ground that the robot ahead has driven and left"
    STOP_HOLDS = "G: no body moves between the operator's stop and release"


class Breach(Exception):  # noqa: N818 - what a search looks for, not an error of ours
    """A property is broken."""

    def __init__(self, broken: Property, order: Order) -> None:
        super().__init__(broken.value)
        self.broken, self.order = broken, order


def judge(asked: Collection[Property], state: State, order: Order) -> None:
    """Raise `Breach` if one of the properties asked for breaks as a body begins to move by an order."""
    for broken in breaks(state, order):
        if broken in asked:
            raise Breach(broken, order)


def breaks(state: State, order: Order) -> Iterator[Property]:
    """The properties that an order obeyed breaks."""
    others = [body.motion for j, body in enumerate(state.bodies) if j != order.robot and body.motion]
    if any(motion.fence[:2] != order.fence[:2] for motion in others):
        yield Property.ONE_FENCE
    who = state.fence.who
    unnamed = who.robot != order.robot if isinstance(who, Named) else who in {May.NOBODY, May.STOPPED}
    if unnamed or (others and Kind.LEASE in {order.kind, *(motion.kind for motion in others)}):
        yield Property.NAMED_MOVES
    if order.form is not None:
        yield from breaks_formation(state, order, order.form)
    if order.quality in {Quality.DIRTY, Quality.STALE}:
        yield Property.SCAN_TRUE
    if state.halted:
        yield Property.STOP_HOLDS


def breaks_formation(state: State, order: Order, form: Formation) -> Iterator[Property]:
    """The properties that a strand's step breaks."""
    if state.acted not in {None, form}:
        yield Property.ONE_FORMATION
    for member in form.places:
        body = state.bodies[member.robot]
        drives_again = member.robot == order.robot and body.ground is not None
        elsewhere = body.ground is None and not body.motion and body.place != member.place
        if drives_again or elsewhere:  # the robot that sends its first step believes to stand there, too
            yield Property.PLACES_TRUE
    ahead = form.beside(order.robot, -1)
    if ahead and state.bodies[ahead.robot].ground != order.ground:
        yield Property.GROUND_LEFT
