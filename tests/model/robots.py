"""What robots learn from odometry and from each other; what they do of their own accord is `acting.py`."""

from tests.model.rules import Rule
from tests.model.setting import Setting
from tests.model.state import FormationTold, Grant, Message, Odometry, PathTold, Report, State, ToRobot, put
from tests.model.values import Fence, Formation, May, Mode, Named, Reading, Reported, Robot


def leads(setting: Setting, i: int, robot: Robot, epoch_of: Fence) -> bool:
    """Is this life of robot `i` the coordinator?"""
    epoch = epoch_of.epoch
    return epoch.robot == i and (epoch.life == robot.life or not setting.on(Rule.EPOCH_NAMES_LIFE))


def stands_anew(setting: Setting, robot: Robot, reading: Reading) -> bool:
    """Has the body obeyed this life's order to stand?"""
    return reading.ended.life >= robot.life or not setting.on(Rule.NEW_LIFE_STANDS)


def place_counts(setting: Setting, robot: Robot) -> bool:
    """May the robot report its place?"""
    reading = robot.reading
    if reading is None or robot.mode is not Mode.BOUND:
        return False
    standing = not reading.moving or not setting.on(Rule.PLACE_STANDING)
    return standing and stands_anew(setting, robot, reading)


def own_report(robot: Robot) -> Reported:
    """What the robot says of itself."""
    assert robot.reading
    assert robot.know
    return Reported(robot.reading.place, robot.life, robot.know.turn)


def report(setting: Setting, state: State, i: int, robot: Robot) -> frozenset[Message]:
    """The report that robot `i` sends, unless its coordinator needs none."""
    know = robot.know
    if know is None or not place_counts(setting, robot):
        return frozenset()
    to = know.epoch.robot
    if to not in range(setting.bounds.robots) or to == i:
        return frozenset()
    if know.who is May.ALL and setting.on(Rule.ONE_FORMATION):
        return frozenset()
    said = own_report(robot)
    boss = state.robots[to]
    if boss.know and boss.know.epoch == know.epoch and boss.reports and boss.gave:
        had, needed = boss.reports[i], boss.gave[i]
        if needed and setting.on(Rule.PLACE_OF_A_LATER_TURN):
            needed += 1
        known = had and had[:2] == said[:2] and had.turn >= min(said.turn, needed)
        if known and setting.on(Rule.PLACE_AFTER_OWN_TURN):
            return frozenset()
    return frozenset({Report(to, know.epoch, i, said)})


def hear_odometry(setting: Setting, state: State, message: Odometry) -> State | None:
    """Robot `message.to` learns of its fence and body."""
    i, fence, reading = message
    robot, on = state.robots[i], setting.on
    granted: frozenset[Message] = frozenset()
    know = robot.know
    if know is None or fence[:2] > know[:2] or (fence != know and not on(Rule.NEXT_TURN_ONLY)):
        robot = hear_fence(setting, i, robot, fence, reading)
    elif fence[:2] != know[:2] or (on(Rule.ODOMETRY_NUMBERED) and robot.reading and reading < robot.reading):
        return None
    else:
        robot = robot._replace(reading=reading)
        if robot.pending and reading.ended >= robot.pending:
            robot = robot._replace(pending=None)
            if robot.mode is Mode.MEMBER:
                granted = to_behind(i, robot, granting=True)
    known = robot.know
    assert known
    if robot.mode is Mode.BOUND and takes_turn(setting, i, robot, reading):
        robot = robot._replace(mode=Mode.JOINING)
    own = robot.form if robot.reports else None
    if own and robot.mode is Mode.BOUND and known.who is May.ALL and in_its_turn(setting, known, own):
        robot = enters(setting, i, robot, own)
    return state.with_robot(i, robot, *granted, *report(setting, state, i, robot))


def hear_fence(setting: Setting, i: int, robot: Robot, fence: Fence, reading: Reading) -> Robot:
    """The robot hears of a fence that is new to it."""
    count = 0 if setting.forgets else robot.ordered
    if robot.know and fence.epoch == robot.know.epoch:
        mode = Mode.MEMBER if robot.mode is Mode.MEMBER else Mode.BOUND
        told = robot._replace(know=fence, reading=reading, mode=mode, ordered=count, pending=None)
        if robot.gave and isinstance(fence.who, Named) and not setting.on(Rule.PUT_COUNTS_AT_ONCE):
            return told._replace(gave=put(robot.gave, fence.who.robot, fence.turn))
        return told
    fresh = Robot(robot.life, fence, reading, ordered=count, scan=robot.scan)
    if leads(setting, i, fresh, fence):
        nobody = setting.bounds.robots
        fresh = fresh._replace(reports=(None,) * nobody, gave=(0,) * nobody, put=fence.turn)
    return fresh


def takes_turn(setting: Setting, i: int, robot: Robot, reading: Reading) -> bool:
    """Does the fence give this life a turn that it has not ended?"""
    assert robot.know
    who = robot.know.who
    if isinstance(who, Named):
        mine = who.robot == i and (who.life == robot.life or not setting.on(Rule.LIFE_IN_TURN))
    else:
        mine = who is May.ANY
    return mine and robot.done != robot.know.turn and stands_anew(setting, robot, reading)


def to_behind(i: int, robot: Robot, *, granting: bool) -> frozenset[Message]:
    """What a member tells the one behind: whose plan it follows, or that it has left its ground."""
    assert robot.form
    assert robot.know
    behind = robot.form.beside(i, 1)
    if behind is None:
        return frozenset()
    to, epoch = behind.robot, robot.know.epoch
    return frozenset(
        {Grant(to, epoch, robot.life) if granting else PathTold(to, epoch, robot.life, robot.path)}
    )


def in_its_turn(setting: Setting, fence: Fence, form: Formation) -> bool:
    """Is this the turn that the formation names?"""
    return form.turn == fence.turn or not setting.on(Rule.FORMATION_NAMES_TURN)


def enters(setting: Setting, i: int, robot: Robot, form: Formation) -> Robot:
    """Robot `i` acts on a formation, or stands aside."""
    assert robot.reading
    any_life = not setting.on(Rule.FORMATION_NAMES_LIVES)
    mine = [member for member in form.places if member.robot == i and (member.life == robot.life or any_life)]
    if not mine or (mine[0].place != robot.reading.place and setting.on(Rule.MISFIT_STANDS)):
        return robot._replace(mode=Mode.ASIDE, form=form, path=None)
    plans = robot.life if form.places[0].robot == i else None
    return robot._replace(mode=Mode.MEMBER, form=form, path=plans)


def hear(setting: Setting, state: State, message: ToRobot) -> State | None:
    """A robot receives a report, formation, path or grant."""
    i = message.to
    robot, on = state.robots[i], setting.on
    another = robot.know is None or robot.know.epoch != message.epoch
    if another and not (isinstance(message, Report) and not on(Rule.PLACE_OF_THIS_EPOCH) and robot.know):
        return None
    match message:
        case Report():
            heard = hear_report(setting, robot, message)
            once = on(Rule.PLACE_AFTER_OWN_TURN) and not setting.bounds.faults
        case FormationTold(form=form):
            heard = hear_formation(setting, i, robot, form)
            once = on(Rule.FORMATION_NAMES_LIVES)
        case PathTold() | Grant():
            heard = hear_link(setting, i, robot, message)
            once = on(Rule.FORMATION_NAMES_LIVES)
    if heard is None:
        return None
    return (state.heard(message) if once else state).with_robot(i, heard)


def hear_report(setting: Setting, robot: Robot, message: Report) -> Robot | None:
    """A coordinator hears a report."""
    if robot.reports is None:
        return None
    old = robot.reports[message.robot]
    if old and setting.on(Rule.PLACE_AFTER_OWN_TURN) and message.said.turn < old.turn:
        return None
    return robot._replace(reports=put(robot.reports, message.robot, message.said))


def hear_formation(setting: Setting, i: int, robot: Robot, form: Formation) -> Robot | None:
    """A robot hears of the formation; one that comes early is kept, here: in the net."""
    assert robot.know
    if robot.mode is not Mode.BOUND or robot.form:
        return None
    if robot.know.who is not May.ALL and setting.on(Rule.ACTS_UNDER_ALL):
        return None
    if not in_its_turn(setting, robot.know, form):
        return None
    return enters(setting, i, robot, form)


def hear_link(setting: Setting, i: int, robot: Robot, message: PathTold | Grant) -> Robot | None:
    """A member hears from the robot ahead."""
    if robot.mode is not Mode.MEMBER or robot.form is None:
        return None
    ahead = robot.form.beside(i, -1)
    if setting.on(Rule.LINK_OF_THE_LIFE) and not (ahead and ahead.life == message.life):
        return None
    return (
        robot._replace(path=message.planner)
        if isinstance(message, PathTold)
        else robot._replace(authority=True)
    )
