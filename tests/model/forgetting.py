"""The reductions: what a change of the fence lets a search forget. They change no verdict where they apply.

They apply where `Setting.forgets` says so; `setting.py` lists the rules. Then nothing that follows
from what is forgotten can move a body:
- a report, formation, path or grant of an older epoch: PLACE_OF_THIS_EPOCH refuses it, or the orders
  to which it leads meet EXACT_EPOCH;
- an order of another fence: EXACT_EPOCH and EXACT_TURN refuse it for ever, because NEXT_TURN_ONLY and
  WRITTEN_FIRST let no fence return;
- a raise that the fence has passed, a turn of an earlier number or epoch;
- what a robot has of an older epoch: it has to hear of the new one before anything that it does can matter;
- order numbers of an earlier fence and places of an earlier epoch: STOP_AT_CHANGE has ended all motion.

A raise that is refused only because the fleet is stopped is kept: it may win after the release.
"""

from collections.abc import Iterable, Iterator

from tests.model.register import may_win
from tests.model.rules import Rule
from tests.model.setting import Setting
from tests.model.state import (
    FormationTold,
    Grant,
    Message,
    Odometry,
    Order,
    PathTold,
    Raise,
    Release,
    Report,
    Stand,
    State,
    Turn,
)
from tests.model.values import AT_REST, Body, Fence, OrderNumber, Robot, Scan


def forgotten(setting: Setting, state: State, *, new_epoch: bool) -> State:
    """The state after a change of the fence, without what can matter no more."""
    if not setting.forgets:
        return state
    robots = state.robots
    if new_epoch:
        robots = tuple(older(robot) for robot in robots)
    if setting.forgets_scans:
        robots = tuple(
            robot if usable(setting, robot.scan, state.fence) else robot._replace(scan=None)
            for robot in robots
        )
    return state._replace(
        bodies=tuple(renumbered(body, new_epoch=new_epoch) for body in state.bodies),
        robots=robots,
        net=frozenset(kept(setting, state.net, state.fence, new_epoch=new_epoch)),
    )


def older(robot: Robot) -> Robot:
    """A robot that knows an older epoch: that it does so is all that matters."""
    if robot.know is None:
        return Robot(robot.life, scan=robot.scan)
    return Robot(robot.life, Fence(robot.know.epoch), AT_REST, scan=robot.scan)


def usable(setting: Setting, scan: Scan | None, fence: Fence) -> bool:
    """May a scan serve under a fence that is still to come?"""
    if scan is None or scan.epoch != fence.epoch:
        return False
    return scan.turn < fence.turn < 2 or not setting.on(Rule.TURN_0_SCAN_ONLY_FOR_TURN_1)


def renumbered(body: Body, *, new_epoch: bool) -> Body:
    """Order numbers begin anew with each fence, places with each epoch."""
    return body._replace(
        place=0 if new_epoch else body.place,
        newest=OrderNumber(body.newest.life, 0),
        ended=OrderNumber(body.ended.life, 0),
    )


def kept(setting: Setting, net: Iterable[Message], fence: Fence, *, new_epoch: bool) -> Iterator[Message]:
    """The messages that may still matter."""
    for message in net:
        if isinstance(message, Odometry) and new_epoch:
            yield Odometry(message.to, Fence(message.fence.epoch), AT_REST)
        elif matters(setting, message, fence, new_epoch=new_epoch):
            yield message


def matters(setting: Setting, message: Message, fence: Fence, *, new_epoch: bool) -> bool:
    """May a message still matter under the fence?"""
    match message:
        case Raise(epoch):
            return may_win(setting, epoch, fence)
        case Turn(turn):
            return turn[:2] > fence[:2]
        case Release(generation):
            return generation >= fence.epoch.generation or not setting.on(Rule.RELEASE_NAMES_ITS_STOP)
        case Odometry() | Stand():
            return True
        case Order():
            return False
        case Report() | FormationTold() | PathTold() | Grant():
            return not new_epoch
