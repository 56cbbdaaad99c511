"""What a robot does of its own accord: it raises, stands anew, ends its turn, scans, orders motion."""

from tests.model.register import may_win
from tests.model.robots import report, to_behind
from tests.model.rules import Rule
from tests.model.setting import Setting
from tests.model.state import Order, Raise, Stand, State, Steps
from tests.model.values import Epoch, Fence, Kind, Mode, OrderNumber, Quality, Robot, Scan


def acts(setting: Setting, state: State, i: int) -> Steps:
    """All that robot `i` may do now, but coordinate."""
    robot = state.robots[i]
    if robot.know is None or robot.reading is None:
        return
    yield from raises(setting, state, i, robot, robot.know)
    if setting.forgets and robot.know.epoch != state.fence.epoch:
        return  # nothing that it does in an old epoch can move a body
    stand = Stand(i, robot.life)
    if robot.reading.ended.life < robot.life and stand not in state.net:
        yield f"r{i} orders its body to stand", state.with_robot(i, robot, stand)
    if robot.mode is Mode.JOINING and not (robot.pending and setting.on(Rule.PLACE_ORDERS_ENDED)):
        over = robot._replace(mode=Mode.BOUND, done=robot.know.turn, pending=None)
        yield (
            f"r{i} ends its turn {robot.know.turn}",
            state.with_robot(i, over, *report(setting, state, i, over)),
        )
    yield from scans(setting, state, i, robot)
    yield from orders(setting, state, i, robot)


def raises(setting: Setting, state: State, i: int, robot: Robot, know: Fence) -> Steps:
    """Anybody may raise at any time: why is liveness. A raise that can no longer win is not sent."""
    if not state.raises or i not in setting.bounds.raisers:
        return
    life = robot.life if setting.on(Rule.EPOCH_NAMES_LIFE) else 0
    raised = Raise(Epoch(know.epoch.generation + 1, i, life))
    if may_win(setting, raised.epoch, state.fence) and raised not in state.net:
        yield (
            f"r{i} sends raise {tuple(raised.epoch)}",
            state._replace(net=state.net | {raised}, raises=state.raises - 1),
        )


def is_leader(i: int, robot: Robot) -> bool:
    """Is robot `i` the first of the formation that it acts on?"""
    return robot.mode is Mode.MEMBER and robot.form is not None and robot.form.places[0].robot == i


def scans(setting: Setting, state: State, i: int, robot: Robot) -> Steps:
    """Robot `i` takes a scan, which the world tells with its fence."""
    others_move = any(body.motion for j, body in enumerate(state.bodies) if j != i)
    quality = Quality.DIRTY if others_move else Quality.CLEAN
    scan = Scan(state.fence.epoch, state.fence.turn, state.in_force, quality)
    wanted = robot.mode is Mode.JOINING or is_leader(i, robot) or setting.bounds.early
    if scan != robot.scan and robot.mode is not Mode.ASIDE and wanted and not robot.sent:
        yield f"r{i} scans ({quality})", state.with_robot(i, robot._replace(scan=scan))


def scan_serves(setting: Setting, robot: Robot) -> bool:
    """May the robot drive on the scan that it has? Rule F6 (a)."""
    scan, know, on = robot.scan, robot.know, setting.on
    if scan is None or know is None or (on(Rule.SCAN_IN_FORCE) and not scan.in_force):
        return False
    if scan.epoch != know.epoch:
        return not on(Rule.SCAN_OF_THIS_EPOCH)
    if scan.turn == know.turn or not on(Rule.SCAN_OF_THIS_TURN):
        return True
    return scan.turn == 0 and (know.turn == 1 or not on(Rule.TURN_0_SCAN_ONLY_FOR_TURN_1))


def may_order(setting: Setting, state: State, i: int, robot: Robot) -> bool:
    """May robot `i` order motion now?"""
    know, reading = robot.know, robot.reading
    if know is None or reading is None or robot.pending:
        return False
    if setting.on(Rule.ORDERS_IN_FORCE) and not reading.in_force:
        return False
    if setting.forgets and know[:2] != state.fence[:2]:
        return False  # its body would refuse the order for ever
    if robot.mode is Mode.JOINING:
        return robot.ordered < setting.bounds.orders and scan_serves(setting, robot)
    return robot.mode is Mode.MEMBER and not robot.sent and may_step(setting, i, robot)


def may_step(setting: Setting, i: int, robot: Robot) -> bool:
    """May a member drive its step of the strand? The leader by its scan, a follower by authority."""
    if is_leader(i, robot):
        return scan_serves(setting, robot)
    return robot.path is not None and (robot.authority or not setting.on(Rule.MOVES_BY_AUTHORITY))


def orders(setting: Setting, state: State, i: int, robot: Robot) -> Steps:
    """Robot `i` orders its body to drive: one step of its turn, or of the strand."""
    if not may_order(setting, state, i, robot):
        return
    assert robot.know
    number = OrderNumber(robot.life, robot.ordered + 1)
    sent = robot._replace(ordered=number.nth, pending=number)
    quality = robot.scan.quality if robot.scan else Quality.NONE
    if robot.mode is Mode.JOINING:
        order = Order(i, robot.know, Kind.LEASE, number, None, quality, robot.path)
        yield f"r{i} orders {order.kind} {tuple(number)}", state.with_robot(i, sent, order)
        return
    if not is_leader(i, robot):
        quality = Quality.NONE
    order = Order(i, robot.know, Kind.STRAND, number, robot.form, quality, robot.path)
    told = to_behind(i, robot, granting=False)
    yield (
        f"r{i} orders {order.kind} {tuple(number)}",
        state.with_robot(i, sent._replace(sent=True), order, *told),
    )
