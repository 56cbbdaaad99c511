"""The world's process: the fence and what a change of it does to bodies; the operator; starting again."""

from tests.model.forgetting import forgotten
from tests.model.register import takes_raise, takes_turn
from tests.model.rules import Rule
from tests.model.setting import Setting
from tests.model.state import Raise, Release, State, Steps, Turn
from tests.model.values import REGISTER_NUMBER, Body, Epoch, Fence, May


def changed(setting: Setting, state: State, fence: Fence) -> State:
    """The fence becomes `fence`: bodies stop, and what can matter no more is forgotten."""
    new_epoch = fence.epoch != state.fence.epoch
    state = state._replace(
        bodies=tuple(halted(setting, body, new_epoch=new_epoch) for body in state.bodies),
        acted=None if new_epoch else state.acted,
        disk=None if setting.on(Rule.WRITTEN_FIRST) else state.fence,
        fence=fence,
    )
    return forgotten(setting, state, new_epoch=new_epoch)


def halted(setting: Setting, body: Body, *, new_epoch: bool) -> Body:
    """A body whose fence changes: it stops, or begins to brake."""
    motion = body.motion
    if motion and setting.on(Rule.STOP_AT_CHANGE):
        motion = motion._replace(braking=True) if setting.bounds.brake else None
    place = body.place + (body.motion is not None and motion is None)
    return body._replace(place=place, motion=motion, ground=None if new_epoch else body.ground)


def hear_raise(setting: Setting, state: State, message: Raise) -> Steps:
    """The register receives a raise."""
    if takes_raise(setting, message.epoch, state.fence):
        before = state.heard(message) if setting.on(Rule.WRITTEN_FIRST) else state
        yield f"raise {tuple(message.epoch)} -> world", changed(setting, before, Fence(message.epoch))


def hear_turn(setting: Setting, state: State, message: Turn) -> Steps:
    """The register receives a turn."""
    if takes_turn(setting, message.fence, state.fence):
        before = state.heard(message) if setting.on(Rule.NEXT_TURN_ONLY) else state
        yield (
            f"turn {message.fence.turn} for {said(message.fence)} -> world",
            changed(setting, before, message.fence),
        )


def said(fence: Fence) -> str:
    """The robot that a fence names, in a trace."""
    return fence.who.value if isinstance(fence.who, May) else f"r{fence.who.robot} (life {fence.who.life})"


def next_generation(state: State, number: int, who: May) -> Fence:
    """The fence that the register takes of its own."""
    return Fence(Epoch(state.fence.epoch.generation + 1, number, 0), 0, who)


def operator_steps(setting: Setting, state: State) -> Steps:
    """The operator stops the fleet, or asks for its release."""
    if state.stops:
        stop = next_generation(state, REGISTER_NUMBER, May.STOPPED)
        yield (
            "the operator stops the fleet",
            changed(setting, state, stop)._replace(stops=state.stops - 1, halted=True),
        )
    release = Release(state.fence.epoch.generation)
    if state.fence.who is May.STOPPED and release not in state.net:
        yield (
            f"the operator releases the stop of generation {release.generation}",
            state._replace(net=state.net | {release}, halted=False),
        )


def hear_release(setting: Setting, state: State, message: Release) -> Steps:
    """The register receives a release; it stays in the net, for a put is repeated."""
    fits = message.generation == state.fence.epoch.generation or not setting.on(Rule.RELEASE_NAMES_ITS_STOP)
    if state.fence.who is May.STOPPED and fits:
        free = next_generation(state, REGISTER_NUMBER, May.NOBODY)
        yield f"release of generation {message.generation} -> world", changed(setting, state, free)


def restart_world(setting: Setting, state: State) -> Steps:
    """The world is killed and started again: the fence is on disk, order numbers are not."""
    bodies = tuple(Body(body.place + (body.motion is not None), ground=body.ground) for body in state.bodies)
    read = state.fence if setting.on(Rule.WRITTEN_FIRST) else state.disk or state.fence
    state = state._replace(bodies=bodies, faults=state.faults - 1, fence=read)
    stays = read.who is May.STOPPED and setting.on(Rule.STOPPED_SURVIVES_RESTART)
    raised = next_generation(state, setting.bounds.world, May.STOPPED if stays else May.NOBODY)
    yield (
        "world restarts",
        changed(setting, state, raised) if setting.on(Rule.RESUMED_WORLD_RAISES) else state,
    )
