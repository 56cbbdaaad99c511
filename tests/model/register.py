"""The register: what it takes and what it refuses."""

from tests.model.rules import Rule
from tests.model.setting import Setting
from tests.model.values import Epoch, Fence, May


def may_win(setting: Setting, epoch: Epoch, fence: Fence) -> bool:
    """Would a raise to `epoch` replace `fence`, if nobody had stopped the fleet?"""
    if epoch.generation == fence.epoch.generation + 1:
        return True
    tie = fence.turn == 0 or not setting.on(Rule.TIE_AT_TURN_0)
    return epoch.generation == fence.epoch.generation and epoch.robot > fence.epoch.robot and tie


def takes_raise(setting: Setting, epoch: Epoch, fence: Fence) -> bool:
    """Does the register take a raise?"""
    stopped = fence.who is May.STOPPED and setting.on(Rule.STOPPED_REFUSES_RAISES)
    return may_win(setting, epoch, fence) and not stopped


def takes_turn(setting: Setting, turn: Fence, fence: Fence) -> bool:
    """Does the register take a turn?"""
    following = turn.turn == fence.turn + 1 or (not setting.on(Rule.NEXT_TURN_ONLY) and turn != fence)
    return (
        turn.epoch == fence.epoch
        and following
        and (fence.who is not May.ALL or not setting.on(Rule.ALL_IS_LAST))
    )
