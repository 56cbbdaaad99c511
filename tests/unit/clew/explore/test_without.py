"""Each rule of the fence is needed: without it the exploration finds a breach, within a minute."""

import pytest

from clew.explore.explore import explore
from clew.explore.search import Ended
from clew.explore.setting import Setting
from clew.explore.without import RULES, explore_without
from tests.support.long import long

# What breaks first; without authority that is the separation, since F5 has no promise of its own.
BROKEN = {"F1": "F1", "F2": "F2", "F3": "F3", "F4": "F4", "F5": "S2", "F6": "F6"}
SECONDS = 60.0
SETTINGS = {str(each.setting): each.setting for each in RULES.values()}
CLEAN = [RULES[rule].setting for rule in ("F2", "F4", "F5")]  # these are soon explored
CLEAN += [setting for setting in SETTINGS.values() if setting not in CLEAN]


@pytest.mark.parametrize("rule", RULES)
def test_without_a_rule_its_promise_breaks_within_a_minute(rule: str) -> None:
    *_, last = explore_without(rule, SECONDS)
    assert last.explored.broken is not None
    assert (last.explored.broken.promise, last.explored.ended) == (BROKEN[rule], Ended.BREACH)


@pytest.mark.parametrize("setting", [*CLEAN[:3], *long(CLEAN[3:])], ids=lambda setting: setting.name)
def test_with_all_rules_the_same_settings_are_clean(setting: Setting) -> None:
    *_, last = explore(setting, 1, SECONDS)
    assert (last.explored.broken, last.explored.ended) == (None, Ended.COMPLETE)
