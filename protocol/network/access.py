"""The router's access rules for one run: which process of which fleet may send and receive what. Pure.

Rule 1: a message that no rule allows is refused.
Rule 2: a robot sends only on keys with its own name as the sender. It receives only on keys with its own name
        as the receiver. It queries only its own scan and the mission.
Rule 3: every process sees all liveliness tokens of its fleet and declares only its own.
Rule 4: rules use wildcards, so their number grows linearly with the robots, not with the square.
Rule 5: the processes of a fleet have nothing to do with the keys of another.
"""

from collections.abc import Iterator, Mapping, Sequence
from typing import Any

from protocol.keys import WORLD, Keys, robot_name

ANY = "*"

Json = dict[str, Any]


def user_name(keys: Keys, name: str) -> str:
    """The user name of a fleet's process at the router."""
    return f"{keys.fleet}.{name}"


def access_rules(fleets: Mapping[Keys, int]) -> Json:
    """Zenoh's `access_control` settings for fleets of so many robots, by their keys."""
    subjects = {user: rules for keys, robots in fleets.items() for user, rules in _subjects(keys, robots)}
    return {
        "enabled": True,
        "default_permission": "deny",
        "rules": [rule for rules in subjects.values() for rule in rules],
        "subjects": [{"id": name, "usernames": [name]} for name in subjects],
        "policies": [
            {"rules": [rule["id"] for rule in rules], "subjects": [name]} for name, rules in subjects.items()
        ],
    }


def _subjects(keys: Keys, robots: int) -> Iterator[tuple[str, list[Json]]]:
    """The users of one fleet, and what each may do."""
    user = user_name(keys, WORLD)
    yield user, _world_rules(user, keys)
    for robot in map(robot_name, range(1, robots + 1)):
        user = user_name(keys, robot)
        yield user, _robot_rules(user, keys, robot)


def _robot_rules(user: str, keys: Keys, robot: str) -> list[Json]:
    return [
        *_says(user, _said(keys, robot), _said(keys, ANY)),
        *_hears(
            user,
            [
                keys.link(ANY, robot),
                keys.view(ANY, robot),
                keys.odometry(robot),
                keys.logged(robot),
                keys.fault(robot),
            ],
        ),
        *_asks(user, [keys.scan(robot), keys.mission()]),
        *_watches(user, keys),
        _allow(user, "lives", "ingress", ["liveliness_token"], [keys.alive(robot, ANY)]),
    ]


def _world_rules(user: str, keys: Keys) -> list[Json]:
    return [
        *_says(user, told := [keys.odometry(ANY), keys.logged(ANY), keys.fault(ANY)], told),
        *_hears(user, [keys.drive(ANY), keys.fence(ANY), keys.log(ANY)]),
        *_answers(user, [keys.scan(ANY), keys.mission()]),
        *_watches(user, keys),
        _allow(user, "lives", "ingress", ["liveliness_token"], [keys.alive(WORLD, ANY)]),
    ]


def _said(keys: Keys, robot: str) -> list[str]:
    """All that a robot sends on."""
    return [
        keys.link(robot, ANY),
        keys.view(robot, ANY),
        keys.drive(robot),
        keys.fence(robot),
        keys.log(robot),
    ]


def _says(name: str, keys: Sequence[str], subscribed: Sequence[str]) -> list[Json]:
    """Rules for one that sends; it is told subscriptions with their own patterns, else it would not send."""
    return [
        _allow(name, "says", "ingress", ["put"], keys),
        _allow(name, "is-told-who-hears", "egress", ["declare_subscriber"], subscribed),
    ]


def _hears(name: str, keys: Sequence[str]) -> list[Json]:
    return [
        _allow(name, "listens", "ingress", ["declare_subscriber"], keys),
        _allow(name, "hears", "egress", ["put"], keys),
    ]


def _asks(name: str, keys: Sequence[str]) -> list[Json]:
    return [
        _allow(name, "asks", "ingress", ["query"], keys),
        _allow(name, "is-answered", "egress", ["declare_queryable", "reply"], keys),
    ]


def _answers(name: str, keys: Sequence[str]) -> list[Json]:
    return [
        _allow(name, "answers", "ingress", ["declare_queryable", "reply"], keys),
        _allow(name, "is-asked", "egress", ["query"], keys),
    ]


def _watches(name: str, keys: Keys) -> list[Json]:
    tokens = [keys.alive(ANY, ANY)]
    return [
        _allow(name, "watches", "ingress", ["declare_liveliness_subscriber", "liveliness_query"], tokens),
        _allow(name, "sees", "egress", ["liveliness_token"], tokens),
    ]


def _allow(name: str, what: str, flow: str, messages: Sequence[str], keys: Sequence[str]) -> Json:
    """One rule; the flow is seen from the router: `ingress` comes from the process."""
    return {
        "id": f"{name}-{what}",
        "permission": "allow",
        "flows": [flow],
        "messages": list(messages),
        "key_exprs": list(keys),
    }
