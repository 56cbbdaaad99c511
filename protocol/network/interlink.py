"""The link between the two routers of a fleet: if one router dies, the other carries the fleet. Pure.

Rule 1: the second router connects to the first, at the socket of its clients, with a user name of its own.
        The first connects to nobody. The second tries for ever: whichever is started again, they meet again.
Rule 2: a router may forward everything on the keys of the run's fleets: a robot's messages are checked by
        the router that the robot is connected to.
Rule 3: only the accepting side learns a user name. So the second router knows the first by its Zenoh id,
        which each run draws anew. Clients see that id, so a client of the second router could claim it while
        the first is away; but only a process that can open the private folder is a client, and it can read
        all passwords there. A TCP port would be worse: any user of the machine can take it when its router
        dies.
"""

from collections.abc import Iterable

from protocol.keys import Keys
from protocol.network.access import Json

ROUTER = "router"
"""The user name of the second router at the first."""
ID_BITS = 128
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


def with_other_router(access: Json, fleets: Iterable[Keys], first: str, *, asks: bool) -> Json:
    """A run's access rules with those of the other router; the second `asks` the one with the id `first`."""
    rule = {
        "id": ROUTER,
        "permission": "allow",
        "flows": ["ingress", "egress"],
        "messages": list(EVERYTHING),
        "key_exprs": [f"{keys.root}/**" for keys in fleets],
    }
    subject = {"zids": [first]} if asks else {"usernames": [ROUTER]}
    return access | {
        "rules": [*access["rules"], rule],
        "subjects": [*access["subjects"], {"id": ROUTER, **subject}],
        "policies": [*access["policies"], {"rules": [ROUTER], "subjects": [ROUTER]}],
    }
