"""Bodies: which orders they obey, and the properties that the judge asks of every order obeyed."""

from enum import StrEnum

from tests.model.messages import Message, Order, Stand
from tests.model.rules import Rule
from tests.model.setting import Setting
from tests.model.state import State, Steps, put
from tests.model.values import Formation, Kind, May, Motion, Named, OrderNumber, Quality, Robot


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


def obeyed(order: Order) -> str:
    """The line of a trace in which a body obeys an order."""
    epoch, turn = tuple(order.fence.epoch), order.fence.turn
    return f"body {order.robot} obeys {order.kind} {tuple(order.number)} of epoch {epoch} turn {turn}"


def obeys(setting: Setting, state: State, order: Order) -> bool:
    """Does the body act on an order? Rule F1."""
    body, fence, on = state.bodies[order.robot], state.fence, setting.on
    if body.motion or order.number <= body.newest:
        return False
    if on(Rule.EXACT_EPOCH) and order.fence.epoch != fence.epoch:
        return False
    if on(Rule.EXACT_TURN) and order.fence.turn != fence.turn:
        return False
    return names(setting, fence.who, order) or not on(Rule.NAMED_ROBOT)


def names(setting: Setting, who: May | Named, order: Order) -> bool:
    """May the order's robot move?"""
    if isinstance(who, Named):
        return who.robot == order.robot and (
            who.life == order.number.life or not setting.on(Rule.LIFE_IN_TURN)
        )
    return who is May.ALL or who is May.ANY


def obey(setting: Setting, state: State, order: Order) -> State | None:
    """A body receives an order. Raises `Breach` where it obeys and a property is broken."""
    if not obeys(setting, state, order):
        return None
    judge(state, order)
    i = order.robot
    motion = Motion(order.fence, order.kind, order.number, braking=False, ground=order.ground)
    robots = tuple(robot if j == i else seen_moving(robot) for j, robot in enumerate(state.robots))
    forgets_number = setting.forgets and setting.on(Rule.RESUMED_WORLD_RAISES)
    net = frozenset(
        stale(message, i)
        for message in state.net
        if not (forgets_number and isinstance(message, Order) and passed(message, order))
    )
    return state._replace(
        bodies=put(state.bodies, i, state.bodies[i]._replace(motion=motion, newest=order.number)),
        robots=robots,
        net=net,
        acted=order.form if order.kind is Kind.STRAND else state.acted,
    )


def passed(message: Order, order: Order) -> bool:
    """Is a message an order that the body will refuse for ever, by its number?"""
    return message.robot == order.robot and message.number <= order.number


def seen_moving(robot: Robot) -> Robot:
    """A robot's scan after another body has moved."""
    if robot.scan is None or robot.scan.quality is not Quality.CLEAN:
        return robot
    return robot._replace(scan=robot.scan._replace(quality=Quality.STALE))


def stale(message: Message, moving: int) -> Message:
    """An order in flight rests on a scan that another body's motion makes stale."""
    if isinstance(message, Order) and message.robot != moving and message.quality is Quality.CLEAN:
        return message._replace(quality=Quality.STALE)
    return message


def judge(state: State, order: Order) -> None:
    """All properties, when a body is about to move by an order."""
    others = [body.motion for j, body in enumerate(state.bodies) if j != order.robot and body.motion]
    if any(motion.fence[:2] != order.fence[:2] for motion in others):
        raise Breach(Property.ONE_FENCE, order)
    who = state.fence.who
    unnamed = who.robot != order.robot if isinstance(who, Named) else who in {May.NOBODY, May.STOPPED}
    if unnamed or (others and Kind.LEASE in {order.kind, *(motion.kind for motion in others)}):
        raise Breach(Property.NAMED_MOVES, order)
    if order.form is not None:
        judge_formation(state, order, order.form)
    if order.quality in {Quality.DIRTY, Quality.STALE}:
        raise Breach(Property.SCAN_TRUE, order)
    if state.halted:
        raise Breach(Property.STOP_HOLDS, order)


def judge_formation(state: State, order: Order, form: Formation) -> None:
    """The properties of a strand's step."""
    if state.acted not in {None, form}:
        raise Breach(Property.ONE_FORMATION, order)
    for member in form.places:
        body = state.bodies[member.robot]
        drives_again = member.robot == order.robot and body.ground is not None
        elsewhere = body.ground is None and not body.motion and body.place != member.place
        if drives_again or elsewhere:  # the robot that sends its first step believes to stand there, too
            raise Breach(Property.PLACES_TRUE, order)
    ahead = form.beside(order.robot, -1)
    if ahead and state.bodies[ahead.robot].ground != order.ground:
        raise Breach(Property.GROUND_LEFT, order)


def stand(state: State, message: Stand) -> Steps:
    """A body receives an order to stand: it bears no fence and is always obeyed."""
    i, number = message.robot, OrderNumber(message.life, 0)
    body = state.bodies[i]
    if number > body.newest:
        place = body.place + (body.motion is not None)
        stood = body._replace(place=place, motion=None, newest=number, ended=number)
        yield f"body {i} obeys the order to stand", state.heard(message).with_body(i, stood)


def come_to_rest(state: State, i: int) -> Steps:
    """A body has driven its order, or braked."""
    body = state.bodies[i]
    if body.motion is None:
        return
    motion, rested = body.motion, body._replace(place=body.place + 1, motion=None)
    if not motion.braking:
        rested = rested._replace(ended=motion.number)
        if motion.kind is Kind.STRAND:
            rested = rested._replace(ground=motion.ground)
    yield f"body {i} comes to rest", state.with_body(i, rested)
