"""How two routers of one fleet are linked, so that either can carry it when the other dies. Pure.

Rule 1: the second asks the first, as a user of its own; the first asks nobody. One that comes back is
        found again by the other's asking, or asks itself.
Rule 2: a router may pass on everything on the fleet's keys: what robots may say has been judged where they
        are linked.
Rule 3: only who is asked learns a user's name. So the second knows the first by the kind of the link between
        them, which must be none that it listens on: nobody else can come by it.
"""

from protocol.keys import Keys
from protocol.network.access import Json

ROUTER = "router"
"""The user that the second router is to the first."""
PROTOCOL = "tcp"
"""Of the link between them, on loopback; clients come by another."""
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


def with_other_router(access: Json, keys: Keys, *, asks: bool) -> Json:
    """A fleet's access rules, and what the other router may do; the second is the one that `asks`."""
    rule = {
        "id": ROUTER,
        "permission": "allow",
        "flows": ["ingress", "egress"],
        "messages": list(EVERYTHING),
        "key_exprs": [f"{keys.root}/**"],
    }
    subject = {"link_protocols": [PROTOCOL]} if asks else {"usernames": [ROUTER]}
    return access | {
        "rules": [*access["rules"], rule],
        "subjects": [*access["subjects"], {"id": ROUTER, **subject}],
        "policies": [*access["policies"], {"rules": [ROUTER], "subjects": [ROUTER]}],
    }
