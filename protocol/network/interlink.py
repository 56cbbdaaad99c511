"""The link between the two routers of a fleet: if one router dies, the other carries the fleet. Pure.

Rule 1: the second router connects to the first, with a user name of its own. The first connects to nobody. So
        a restarted second router connects again, and a restarted first router is found by the second.
Rule 2: a router may forward everything on the keys of the run's fleets: a robot's messages are checked by
        the router that the robot is connected to.
Rule 3: only the accepting side learns a user name. So the second router knows the first by the protocol of
        their link. The second must not listen on that protocol, so that no other process can use it.
"""

from collections.abc import Iterable

from protocol.keys import Keys
from protocol.network.access import Json

ROUTER = "router"
"""The user name of the second router at the first."""
PROTOCOL = "tcp"
"""The protocol of the link between routers, on loopback; clients use another."""
EVERYTHING = (
    "put",
    "delete",
    "query",
    "reply",
    "declare_subscriber",
    "declare_queryable",
    "liveliness_token",
    "liveliness_query",
    "declare_liveliness_subscriber",
)


def with_other_router(access: Json, fleets: Iterable[Keys], *, asks: bool) -> Json:
    """A run's access rules with those of the other router; the second router `asks` the first."""
    rule = {
        "id": ROUTER,
        "permission": "allow",
        "flows": ["ingress", "egress"],
        "messages": list(EVERYTHING),
        "key_exprs": [f"{keys.root}/**" for keys in fleets],
    }
    subject = {"link_protocols": [PROTOCOL]} if asks else {"usernames": [ROUTER]}
    return access | {
        "rules": [*access["rules"], rule],
        "subjects": [*access["subjects"], {"id": ROUTER, **subject}],
        "policies": [*access["policies"], {"rules": [ROUTER], "subjects": [ROUTER]}],
    }
