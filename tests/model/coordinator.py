"""What a coordinator does beside its state: it puts turns, makes the formation and puts all (F4)."""

from tests.model.robots import leads, own_report, place_counts
from tests.model.rules import Rule
from tests.model.setting import Setting
from tests.model.state import FormationTold, State, Steps, Turn, put
from tests.model.values import Fence, Formation, May, Named, Place, Reported, Robot

Reports = tuple[Reported | None, ...]


def coordinates(setting: Setting, state: State, i: int) -> Steps:
    """All that robot `i` may do as the coordinator."""
    robot, on = state.robots[i], setting.on
    know = robot.know
    if know is None or robot.reports is None or not leads(setting, i, robot, know):
        return
    if setting.forgets and know.epoch != state.fence.epoch:
        return  # nothing that it puts in an old epoch can be taken
    turn = know.turn + 1
    if on(Rule.NEXT_PUT_WHEN_TOLD) and robot.put >= turn:
        return
    if know.who is May.ALL and on(Rule.NOTHING_AFTER_ALL) and on(Rule.ONE_FORMATION):
        return
    counts = place_counts(setting, robot) or (robot.form and not on(Rule.ONE_FORMATION))
    reports = put(robot.reports, i, own_report(robot) if counts else None)
    yield from puts_turns(setting, state, i, reports)
    yield from puts_all(setting, state, i, reports)


def said_of(who: May | Named) -> str:
    """The robot that a turn names, in a trace."""
    return who.value if isinstance(who, May) else f"r{who.robot}"


def puts_turns(setting: Setting, state: State, i: int, reports: Reports) -> Steps:
    """It gives a turn to a robot that has reported, or to nobody."""
    robot, on, bounds = state.robots[i], setting.on, setting.bounds
    assert robot.know
    assert robot.gave
    know, turn, after_all = robot.know, robot.know.turn + 1, not on(Rule.NOTHING_AFTER_ALL)
    if turn > bounds.turns + after_all or (know.who is May.ALL and not after_all):
        return
    if robot.form and on(Rule.ALL_AFTER_FORMATION) and not after_all:
        return
    for j, said in enumerate(reports):
        if said is None:
            continue
        who = Named(j, said.life) if on(Rule.ONE_NAMED) else May.ANY
        message = Turn(Fence(know.epoch, turn, who))
        if message not in state.net:
            gave = put(robot.gave, j, turn) if on(Rule.PUT_COUNTS_AT_ONCE) else robot.gave
            after = robot._replace(put=turn, gave=gave)
            yield f"r{i} puts turn {turn} for {said_of(who)}", state.with_robot(i, after, message)
    message = Turn(Fence(know.epoch, turn, May.NOBODY))
    if bounds.nobody_turns and message not in state.net:
        yield f"r{i} puts turn {turn} for nobody", state.with_robot(i, robot._replace(put=turn), message)


def place_serves(setting: Setting, said: Reported, gave: int) -> bool:
    """May a reported place go into the formation? `gave`: the last turn put for that robot, 0 for none."""
    if gave and setting.on(Rule.PLACE_OF_A_LATER_TURN) and said.turn <= gave:
        return False
    return said.turn >= gave or not setting.on(Rule.PLACE_AFTER_OWN_TURN)


def made(setting: Setting, i: int, robot: Robot, reports: Reports) -> Formation | None:
    """The formation of what has been reported; None where fewer than two places serve."""
    assert robot.know
    assert robot.gave
    gave = robot.gave
    places = [
        Place(j, said.place, said.life)
        for j, said in enumerate(reports)
        if said and place_serves(setting, said, gave[j])
    ]
    if len(places) < 2:
        return None
    places.sort(
        key=lambda member: ((member.robot == i) if setting.bounds.tail else (member.robot != i), member.robot)
    )
    turn = robot.know.turn + (robot.know.who is not May.ALL) if setting.on(Rule.FORMATION_NAMES_TURN) else 0
    return Formation(robot.know.epoch, turn, tuple(places))


def puts_all(setting: Setting, state: State, i: int, reports: Reports) -> Steps:
    """It makes the formation, tells its members and puts all; or all again, with the formation it has."""
    robot, on = state.robots[i], setting.on
    assert robot.know
    know, form = robot.know, robot.form
    if form is None or not on(Rule.ONE_FORMATION):
        form = made(setting, i, robot, reports)
        if form is None:
            return
    told = [FormationTold(member.robot, know.epoch, form) for member in form.places if member.robot != i]
    names = ", ".join(f"r{member.robot} at {member.place}" for member in form.places)
    at_once = on(Rule.ALL_AFTER_FORMATION)
    if robot.form != form and (not at_once or know.who is May.ALL):
        yield f"r{i} makes formation {names}", state.with_robot(i, robot._replace(form=form), *told)
    message = Turn(Fence(know.epoch, know.turn + 1, May.ALL))
    if know.who is not May.ALL and (robot.form or at_once) and message not in state.net:
        after = robot._replace(form=form, put=know.turn + 1)
        yield (
            f"r{i} makes formation {names}, puts turn {know.turn + 1} for all",
            state.with_robot(i, after, message, *told),
        )
