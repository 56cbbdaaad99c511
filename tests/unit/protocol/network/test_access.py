"""The router's access rules: linear in the number of robots, and allowing nothing unnecessary."""

import pytest

from protocol.keys import Keys
from protocol.network.access import Json, access_rules, user_name

KEYS = Keys("f", "t")
ROBOTS = 4


def allowed(name: str, flow: str, message: str, *others: Keys) -> set[str]:
    """The keys on which a process may do this beside other fleets; the flow is seen from the router."""
    settings = access_rules({KEYS: ROBOTS, **dict.fromkeys(others, ROBOTS)})
    rules: dict[str, Json] = {rule["id"]: rule for rule in settings["rules"]}
    subjects = {
        subject["id"] for subject in settings["subjects"] if subject["usernames"] == [user_name(KEYS, name)]
    }
    return {
        key
        for policy in settings["policies"]
        if subjects.intersection(policy["subjects"])
        for rule in (rules[identity] for identity in policy["rules"])
        if flow in rule["flows"] and message in rule["messages"]
        for key in rule["key_exprs"]
    }


def test_messages_that_no_rule_allows_are_refused() -> None:
    settings = access_rules({KEYS: ROBOTS})
    assert settings["enabled"]
    assert settings["default_permission"] == "deny"
    assert {rule["permission"] for rule in settings["rules"]} == {"allow"}
    assert {flow for rule in settings["rules"] for flow in rule["flows"]} == {"ingress", "egress"}


def said(robot: str) -> set[str]:
    """All that a robot sends on."""
    return {
        KEYS.link(robot, "*"),
        KEYS.view(robot, "*"),
        KEYS.drive(robot),
        KEYS.fence(robot),
        KEYS.log(robot),
    }


def test_a_robot_sends_only_on_keys_with_its_own_name_as_sender() -> None:
    assert allowed("r2", "ingress", "put") == said("r2")


@pytest.mark.parametrize(("flow", "message"), [("ingress", "declare_subscriber"), ("egress", "put")])
def test_a_robot_receives_only_keys_addressed_to_it(flow: str, message: str) -> None:
    hears = {
        KEYS.link("*", "r2"),
        KEYS.view("*", "r2"),
        KEYS.odometry("r2"),
        KEYS.logged("r2"),
        KEYS.fault("r2"),
    }
    assert allowed("r2", flow, message) == hears


def test_a_robot_is_told_the_subscriptions_to_what_it_sends_with_their_own_patterns() -> None:
    assert allowed("r2", "egress", "declare_subscriber") == said("*")


def test_a_robot_queries_its_own_scan_and_the_mission_and_answers_no_query() -> None:
    assert allowed("r2", "ingress", "query") == {KEYS.scan("r2"), KEYS.mission()}
    assert allowed("r2", "egress", "reply") == {KEYS.scan("r2"), KEYS.mission()}
    assert allowed("r2", "ingress", "reply") == allowed("r2", "ingress", "declare_queryable") == set()


@pytest.mark.parametrize("name", ["r2", "world"])
def test_every_process_sees_all_tokens_and_declares_only_its_own(name: str) -> None:
    every = {KEYS.alive("*", "*")}
    assert allowed(name, "ingress", "liveliness_token") == {KEYS.alive(name, "*")}
    assert allowed(name, "egress", "liveliness_token") == every
    assert allowed(name, "ingress", "declare_liveliness_subscriber") == every
    assert allowed(name, "ingress", "liveliness_query") == every


def test_the_world_sends_odometry_and_acknowledgements_and_receives_orders_puts_and_logs() -> None:
    assert allowed("world", "ingress", "put") == {KEYS.odometry("*"), KEYS.logged("*"), KEYS.fault("*")}
    assert allowed("world", "egress", "put") == {KEYS.drive("*"), KEYS.fence("*"), KEYS.log("*")}


def test_the_world_answers_scan_and_mission_queries_and_sends_no_query() -> None:
    assert allowed("world", "ingress", "declare_queryable") == {KEYS.scan("*"), KEYS.mission()}
    assert allowed("world", "egress", "query") == {KEYS.scan("*"), KEYS.mission()}
    assert allowed("world", "ingress", "query") == set()


def test_no_process_may_delete_and_foreign_processes_may_do_nothing() -> None:
    assert allowed("r2", "ingress", "delete") == allowed("world", "ingress", "delete") == set()
    assert allowed(f"r{ROBOTS + 1}", "ingress", "put") == set()


@pytest.mark.parametrize("name", ["r2", "world"])
@pytest.mark.parametrize("flow", ["ingress", "egress"])
@pytest.mark.parametrize(
    "message", ["put", "query", "reply", "declare_subscriber", "declare_queryable", "liveliness_token"]
)
def test_another_fleet_on_the_same_router_gives_a_process_no_further_rights(
    name: str, flow: str, message: str
) -> None:
    assert allowed(name, flow, message, Keys("g", "t")) == allowed(name, flow, message)


def test_the_number_of_rules_grows_linearly_with_the_robots() -> None:
    few, many = (len(str(access_rules({KEYS: robots}))) for robots in (100, 200))
    assert many < 2.1 * few
