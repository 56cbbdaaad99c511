from collections import Counter

from clew.swarm.draws import Draws
from clew.swarm.strikes import BEGINS_S, LASTS_S, strike
from clew.swarm.window import Window
from protocol.faults.rules import Corrupt, Delay, Drop, Duplicate, MessageRule, Rule

FLEET = Window(5, None)
MailRule = Corrupt | Delay | Drop | Duplicate


def struck(seed: int, robot: int = 3) -> list[Rule]:
    return strike(Draws(seed, "test"), FLEET, robot)


def named(rule: Rule) -> set[str]:
    if isinstance(rule, MessageRule):
        return {*rule.sender, *rule.receiver, *getattr(rule, "group", ())}
    return {rule.target}


def test_a_strike_has_at_most_one_fault_of_a_process_and_two_of_messages_and_one_at_least() -> None:
    strikes = [struck(seed) for seed in range(300)]
    mail = Counter(sum(isinstance(rule, MailRule) for rule in each) for each in strikes)
    assert mail.keys() == {0, 1, 2}
    assert {len(each) for each in strikes} == {1, 2, 3}
    assert max(sum(not isinstance(rule, MailRule) for rule in each) for each in strikes) == 1


def test_most_faults_of_processes_are_on_its_robot() -> None:
    events = [rule for seed in range(300) for rule in struck(seed) if not isinstance(rule, MailRule)]
    on = [named(rule) for rule in events if named(rule) != {"world"}]
    assert 0.75 < sum("r3" in names for names in on) / len(on) < 0.92


def test_its_faults_of_messages_are_short_and_begin_at_once() -> None:
    for seed in range(300):
        for rule in struck(seed):
            assert rule.from_s <= BEGINS_S[1]
            if isinstance(rule, MailRule):
                assert rule.from_s == 0.0
                assert rule.until_s is not None
                assert rule.until_s - rule.from_s <= LASTS_S[1]


def test_mail_of_bodies_is_struck_at_its_receiver_and_mail_to_them_at_its_sender() -> None:
    mail = [rule for seed in range(300) for rule in struck(seed) if isinstance(rule, MailRule) and rule.kinds]
    assert not any(rule.sender for rule in mail if rule.kinds[0] in {"odometry", "scan"})
    assert not any(rule.receiver for rule in mail if rule.kinds[0] in {"drive", "raise"})


def test_of_late_messages_each_has_its_own_delay_or_all_have_the_same() -> None:
    late = [rule for seed in range(300) for rule in struck(seed) if isinstance(rule, Delay)]
    alike = [rule for rule in late if rule.delay_s_min > 0.9 * rule.delay_s_max]
    assert all(rule.delay_s_min == 0.0 for rule in late if rule not in alike)
    assert 0.3 < len(alike) / len(late) < 0.7
