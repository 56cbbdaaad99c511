"""Fault plans: valid files, and the refusal of invalid ones."""

from pathlib import Path
from typing import get_args

import msgspec
import pytest

from protocol.errors import UsageError
from protocol.faults.fit import WAYS, check_fits
from protocol.faults.message_faults import LEFT_ALONE
from protocol.faults.plan import PLANS, Plan, load, uniform
from protocol.faults.rules import Delay, Drop, Kill, MessageKind, Partition, Rule
from protocol.root import ROOT
from protocol.wire.messages import Message
from tests.support.faults import SHIPPED
from world.scenario.fleets import has_several
from world.scenario.reading import find
from world.scenario.scenario import load as load_scenario


def refusal(tmp_path: Path, rule: str, head: str = 'name = "bad"\n') -> str:
    path = tmp_path / "bad.toml"
    path.write_text(f"{head}[[rule]]\n{rule}\n", encoding="utf-8")
    with pytest.raises(UsageError) as refused:
        load(str(path))
    said = str(refused.value)
    assert said.startswith(f"{path}: ")
    assert "\n" not in said
    return said.removeprefix(f"{path}: ")


@pytest.mark.parametrize("name", SHIPPED)
def test_every_shipped_plan_loads_and_has_a_description(name: str) -> None:
    plan = load(name)
    assert plan.name == name
    assert plan.description
    assert plan.rules


def test_the_required_plans_are_shipped() -> None:
    assert {"leader-killed", "middle-killed", "two-neighbours-killed", "tail-killed", "leader-frozen"} <= {
        *SHIPPED
    }
    assert {"robot-restarted", "world-restarted", "router-restarted", "one-way", "flapping"} <= {*SHIPPED}


@pytest.mark.parametrize(
    ("rule", "said"),
    [
        ('fault = "drop"\nprobability = 1.5', "$.rule[0].probability: must be <= 1.0, got 1.5"),
        ('fault = "drop"\nprobability = nan', "$.rule[0].probability: must be >= 0.0, got nan"),
        ('fault = "drop"\nfrom_s = -1.0', "$.rule[0].from_s: must be >= 0.0 s, got -1.0"),
        ('fault = "freeze"\ntarget = "tail"\nfor_s = 0.0', "$.rule[0].for_s: must be > 0.0 s, got 0.0"),
        ('fault = "kill"', "$.rule[0]: must have the field target, got fault"),
        ('fault = "kill"\ntarget = "tail"\npoint = "lunch"', "$.rule[0].point: must be one of after_plan, "),
        ('fault = "drop"\nkind = ["chat"]', "$.rule[0].kind[0]: must be one of ahead, answer, ask, "),
        ('fault = "theft"', "$.rule[0].fault: must be one of corrupt, delay, "),
        ('fault = "drop"\nchance = 0.5', "$.rule[0]: must have no field but fault, name, "),
        ('fault = "drop"\nfrom_s = 2.0\nuntil_s = 1.0', "$.rule[0]: until_s must be > from_s = 2 s, got 1"),
        ('fault = "drop"\nfrom_step = 2\nuntil_step = 2', "$.rule[0]: until_step must be > from_step = 2, "),
        ('fault = "delay"\ndelay_s_min = 2.0\ndelay_s_max = 1.0', "$.rule[0]: delay_s_min must be <= "),
        ('fault = "corrupt"\nbits = 0', "$.rule[0]: bits must be >= 1 where nothing is cut off, got 0"),
        ('fault = "partition"\ngroup = ["r1"]\nperiod_s = 1.0', "$.rule[0]: period_s and cut_s must be "),
        (
            'fault = "partition"\ngroup = ["r1", "r2"]\nothers = ["r2", "r3"]',
            "$.rule[0]: others must have no process of the group, got r2 in both",
        ),
        ('fault = "kill"\ntarget = "world"\npoint = "after_scan"', "$.rule[0]: target must be a robot "),
        (
            'fault = "slow"\ntarget = "r1"\ndelay_s = 0.1\npoint = "mid_drive"',
            "$.rule[0]: point must not be ",
        ),
        (
            'fault = "kill"\ntarget = "r1"\noccurrence = 2',
            "$.rule[0]: occurrence must be 1 where there is no ",
        ),
        ('fault = "drop"\nname = "a b"', "$.rule[0].name: must be 1 to 64 letters, digits, '_',"),
        ('fault = "thaw"\ntarget = "r1"\npoint = "mid_drive"', "$.rule[0]: point must not be given to thaw"),
        ('fault = "thaw"\ntarget = "world"', "$.rule[0]: target must not be the world"),
        ('fault = "slow"\ntarget = "router"\ndelay_s = 0.1', "$.rule[0]: target must not be the router"),
        ('fault = "freeze"\ntarget = "world"', "$.rule[0]: for_s must be given where the world is frozen"),
        (
            'fault = "kill"\ntarget = "r0"',
            "$.rule[0].target: must be a robot as r3, or leader, middle, tail, coordinator, world, router",
        ),
        ('fault = "drop"\nto = ["r1", 3]', "$.rule[0].to[1]: must be a string, got 3"),
        (
            'fault = "drop"\nburst = { enter = 0.6, leave = 0.6, loss = 1.0 }',
            "$.rule[0].burst: enter + leave must be <= 1, got 0.6 + 0.6",
        ),
        (
            'fault = "drop"\nprobability = 0.5\nburst = { enter = 0.1, leave = 0.6, loss = 1.0 }',
            "$.rule[0]: a rule with a burst must have no probability, got 0.5",
        ),
    ],
)
def test_an_invalid_rule_is_refused_with_path_bound_and_value(tmp_path: Path, rule: str, said: str) -> None:
    assert refusal(tmp_path, rule).startswith(said)


def test_a_process_that_is_mistyped_gets_a_suggestion(tmp_path: Path) -> None:
    said = refusal(tmp_path, 'fault = "kill"\ntarget = "leadr"')
    assert said.endswith("got 'leadr'; did you mean 'leader'?")


def test_where_a_list_is_wanted_the_refusal_says_how_to_write_one(tmp_path: Path) -> None:
    said = refusal(tmp_path, 'fault = "drop"\nkind = "ahead"')
    assert said == "$.rule[0].kind: must be a list, got 'ahead'; did you mean ['ahead']?"
    plan = tmp_path / "one.toml"
    plan.write_text('name = "one"\n[rule]\nfault = "drop"\n')
    with pytest.raises(UsageError, match=r"\$\.rule: must be a list, got .*; in TOML, write \[\[rule\]\]$"):
        load(str(plan))


def test_a_broken_relation_is_reported_without_the_whole_rule(tmp_path: Path) -> None:
    said = "$.rule[0]: for_s must be given where the world is frozen: nobody could thaw it"
    assert refusal(tmp_path, 'fault = "freeze"\ntarget = "world"') == said


def test_two_rules_with_the_same_name_are_refused(tmp_path: Path) -> None:
    twice = 'fault = "drop"\nname = "a"\n[[rule]]\nfault = "kill"\ntarget = "tail"\nname = "a"'
    assert refusal(tmp_path, twice) == "$: no two rules may have one name, got a twice"


def test_a_rule_without_a_name_gets_one_and_keeps_it_when_other_rules_are_removed() -> None:
    plan = Plan(name="two", rules=(Drop(), Kill(target="tail")))
    assert [rule.name for rule in plan.rules] == ["drop-1", "kill-2"]
    assert [rule.name for rule in Plan(name="one", rules=plan.rules[1:]).rules] == ["kill-2"]


def test_a_plan_survives_a_round_trip_through_json() -> None:
    for plan in (*map(load, SHIPPED), uniform(loss=0.1, delay_s_max=0.2, repeat=0.3)):
        assert msgspec.json.decode(msgspec.json.encode(plan), type=Plan) == plan


def test_an_unknown_plan_is_refused_with_a_list_of_known_ones() -> None:
    with pytest.raises(UsageError, match="unknown fault plan 'rain': must be one of burst, corrupt, "):
        load("rain")


def test_none_is_a_plan_without_faults() -> None:
    assert load("none") == Plan(name="none")


def test_a_plan_that_is_given_as_a_scenario_is_named_as_that() -> None:
    with pytest.raises(UsageError, match=r"'loss-50' is a fault plan, not a scenario: --faults loss-50"):
        find("loss-50")
    plan = PLANS / "loss-50.toml"
    for of in (load_scenario, has_several):
        with pytest.raises(UsageError, match=rf"^'{plan}' is a fault plan, not a scenario: --faults {plan}$"):
            of(str(plan))


@pytest.mark.parametrize("name", ["grove", "crossing", "launch/scenarios/grove.toml"])
def test_a_scenario_that_is_given_as_a_plan_is_named_as_that(
    name: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(ROOT)
    with pytest.raises(UsageError, match=f"^'{name}' is a scenario, not a fault plan$"):
        load(name)


@pytest.mark.parametrize(
    ("rule", "said"),
    [
        (Kill(target="r6"), r"\.target: must be a robot of the fleet, r1 to r5, got r6"),
        (Kill(target="leader", robots=6), r"\.robots: must be <= 5, the fleet's, got 6"),
        (Drop(sender=("r1", "r9")), r"\.from\[1\]: must be a robot of the fleet, r1 to r5, got r9"),
        (Drop(receiver=("r7",)), r"\.to\[0\]: must be .*, got r7"),
        (Partition(group=("r8",)), r"\.group\[0\]: must be .*, got r8"),
        (Partition(group=("r1",), others=("router", "r8")), r"\.others\[1\]: must be .*, got r8"),
        (Drop(sender=("world",), kinds=("ahead",)), r"\.kind: must be .*, got ahead, which goes from robots"),
        (Drop(receiver=("r2",), kinds=("drive", "log")), r"\.kind: must be .*, got drive, .* to world; log,"),
        (
            Drop(sender=("r1",), receiver=("r1",)),
            r"\.to: must name another process than `from`, got r1, and .*",
        ),
        (Delay(sender=("world",), receiver=("world",), delay_s_max=1.0), r"\.to: must .*, got world, and .*"),
        (Drop(sender=("r3",), kinds=("ask",)), r"\.kind: must be .*, got ask, .* name is not told to world"),
    ],
)
def test_a_plan_that_names_missing_robots_or_messages_does_not_fit(rule: Rule, said: str) -> None:
    with pytest.raises(UsageError, match=rf"fault plan far: \$\.rule\[1\]{said}"):
        check_fits(Plan(name="far", rules=(Drop(), rule)), robots=5)


@pytest.mark.parametrize(
    "rule",
    [
        Kill(target="r6", robots=1),
        Kill(target="tail", robots=6),
        Partition(group=("r6", "world"), others=("router",)),
        Drop(sender=("world", "r1"), kinds=("ahead", "odometry")),
        Drop(receiver=("r6",), kinds=("drive", "odometry")),
        Drop(kinds=("ask",)),
        Drop(sender=("r1", "r2"), receiver=("r2", "r1")),
        Drop(receiver=("r1",)),
    ],
)
def test_a_plan_fits_if_all_its_names_and_one_of_its_kinds_exist(rule: Rule) -> None:
    check_fits(Plan(name="near", rules=(rule,)), robots=6)


def test_every_kind_of_message_has_a_sender_and_a_receiver() -> None:
    assert set(WAYS) == {*get_args(MessageKind)}


def test_rules_can_name_every_kind_of_message_except_faults() -> None:
    tags = {str(kind.__struct_config__.tag) for kind in get_args(Message)}
    assert tags - {*get_args(MessageKind)} == tags & {"faults"}
    assert {"log", "logged"} <= {*LEFT_ALONE}


def test_every_fault_has_a_docstring() -> None:
    assert [kind for kind in get_args(Rule) if not kind.__doc__] == []
