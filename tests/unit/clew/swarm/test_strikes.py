from collections import Counter

from clew.swarm.draws import Draws
from clew.swarm.strikes import LASTS_S, strike
from clew.swarm.window import Window
from protocol.faults.rules import MessageRule, Rule

FLEET = Window(5, None)


def struck(seed: int, robot: int = 3) -> list[Rule]:
    return strike(Draws(seed, "test"), FLEET, robot)


def named(rule: Rule) -> set[str]:
    if isinstance(rule, MessageRule):
        return {*rule.sender, *rule.receiver, *getattr(rule, "group", ())}
    return {rule.target}


def test_a_strike_is_of_one_to_three_faults_and_most_are_on_its_robot() -> None:
    strikes = [struck(seed) for seed in range(300)]
    assert Counter(map(len, strikes)).keys() == {1, 2, 3}
    on = [named(rule) for each in strikes for rule in each if named(rule) and named(rule) != {"world"}]
    assert 0.7 < sum(names == {"r3"} for names in on) / len(on) < 0.9


def test_its_faults_of_messages_are_short_and_begin_at_once() -> None:
    for seed in range(300):
        for rule in struck(seed):
            assert rule.from_s <= 0.6
            if isinstance(rule, MessageRule) and rule.fault != "partition":
                assert rule.until_s is not None
                assert rule.until_s - rule.from_s <= LASTS_S[1]


def test_what_bodies_tell_is_struck_at_its_receiver() -> None:
    for seed in range(300):
        for rule in struck(seed):
            if isinstance(rule, MessageRule) and rule.kinds and rule.kinds[0] in {"odometry", "scan"}:
                assert not rule.sender
