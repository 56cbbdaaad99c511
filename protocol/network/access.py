"""The router's access rules for one run: which process of which fleet may send and receive what. Pure.

Rule 1: a message that no rule allows is refused.
Rule 2: a robot sends only on keys with its own name as the sender. It receives only on keys with its own name
        as the receiver. It queries only its own scan and the mission.
Rule 3: every process sees all liveliness tokens of its fleet and declares only its own.
Rule 4: rules use wildcards, so their number grows linearly with the robots, not with the square.
Rule 5: the processes of a fleet have nothing to do with the keys of another.
Rule 6: what all robots of a fleet may do is one rule. Zenoh copies all rules for each session that it admits,
        with 1,000 robots 9,000 rules in 7 ms, so each rule of a robot costs that of a thousand.
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
    allowed = [each for keys, robots in fleets.items() for each in _allowed(keys, robots)]
    return {
        "enabled": True,
        "default_permission": "deny",
        "rules": [rule for _, rules in allowed for rule in rules],
        "subjects": [
            {"id": name, "usernames": [name]}
            for name in dict.fromkeys(user for users, _ in allowed for user in users)
        ],
        "policies": [
            {"rules": [rule["id"] for rule in rules], "subjects": users} for users, rules in allowed
        ],
    }


def _allowed(keys: Keys, robots: int) -> Iterator[tuple[list[str], list[Json]]]:
    """What users of one fleet may do: each for itself, and all robots alike (rule 6)."""
    world = user_name(keys, WORLD)
    yield [world], _world_rules(world, keys)
    names = {robot: user_name(keys, robot) for robot in map(robot_name, range(1, robots + 1))}
    for robot, user in names.items():
        yield [user], _robot_rules(user, keys, robot)
    every = f"{keys.fleet}/robot"  # no user's name has a slash
    yield [*names.values()], [_is_told(every, _said(keys, ANY)), *_watches(every, keys)]


def _robot_rules(user: str, keys: Keys, robot: str) -> list[Json]:
    return [
        _says(user, _said(keys, robot)),
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
        _allow(user, "lives", "ingress", ["liveliness_token"], [keys.alive(robot, ANY)]),
    ]


def _world_rules(user: str, keys: Keys) -> list[Json]:
    return [
        _says(user, said := [keys.odometry(ANY), keys.logged(ANY), keys.fault(ANY)]),
        _is_told(user, said),
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


def _says(name: str, keys: Sequence[str]) -> Json:
    return _allow(name, "says", "ingress", ["put"], keys)


def _is_told(name: str, subscribed: Sequence[str]) -> Json:
    """One that sends is told subscriptions with their own patterns, else it would not send."""
    return _allow(name, "is-told-who-hears", "egress", ["declare_subscriber"], subscribed)


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
