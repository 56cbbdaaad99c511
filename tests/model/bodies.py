"""Bodies: which orders they obey."""

from tests.model.properties import judge
from tests.model.rules import Rule
from tests.model.setting import Setting
from tests.model.state import Message, Order, Stand, State, Steps, put
from tests.model.values import Kind, May, Motion, Named, OrderNumber, Quality, Robot


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
    judge(setting.asked, state, order)
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
