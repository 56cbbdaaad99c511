"""Zenoh's settings for the fleet's processes and its routers. Pure; figures were measured with Zenoh 1.10.

Rule 1: there is no scouting, and no shared memory, which would write plain payloads to /dev/shm. Our own
        router admits no process without a password.
"""

from pathlib import Path

from protocol.frames import ROBOTS_MAX
from protocol.network.access import Json, access_rules
from protocol.network.interlink import ROUTER, with_other_router
from protocol.network.session import USERS_FILE, RouterSession, Session
from protocol.wire.codec import SIZE_MAX_BYTES

LEASE_MS = 1000  # 200 ms gave false deaths on a loaded machine; 500 ms and more gave none
# Processes of a large fleet wait longer for their turn on a core. A process that ends is noticed at once, at
# its socket; the lease is for one that is frozen or cut off, and silence tells that as well.
LEASE_MS_PER_ROBOT = 10
# When a large fleet forms a strand, each robot declares whose tokens it watches, and the router compares each
# declaration with those of all. Of 1,000 robots half lost their links in these moments with 10 s.
LEASE_MS_PER_PAIR = 0.03
# A link that is given up at the moment in which it is accepted stays half open (`deafness.py`). So this is
# longer than the longest pause of a process on a busy machine (`LATE_S_MAX`). With the default of 10 s, a
# frozen router would keep us that long from the second one.
OPEN_TIMEOUT_MS = 3000
CONNECT_S = 5.0  # a router that was started before us listens within 1 s
ROBOTS_PER_CONNECT = 150  # in 5 s, so many robots start at load 45
ASK_TIMEOUT_MS = 1000
# When a strand forms, all robots ask for a scan at once, and the world takes 4 ms for each. An answer that
# comes too late is asked for again: with too short a time, a large fleet would ask for ever.
ASK_TIMEOUT_MS_PER_ROBOT = 20
# Of two threads that receive, each message wakes both, and one of them in vain: a client has one link.
CLIENT_THREADS = "(rx: (worker_threads: 1))"
QUEUE_BATCHES = 16  # Zenoh's maximum, allocated on demand; DROP drops what finds no room within 1 ms
# Short periods: all robots should reconnect at about the same time, and a retry is cheap.
RETRY = {"period_init_ms": 100, "period_max_ms": 200, "period_increase_factor": 1.5}
SESSIONS_MAX = ROBOTS_MAX + 500  # with room for restarted processes


def lease_ms(robots: int) -> int:
    """For how long a link may be silent in a fleet of so many robots."""
    return max(LEASE_MS, LEASE_MS_PER_ROBOT * robots, round(LEASE_MS_PER_PAIR * robots**2))


def ask_timeout_ms(robots: int) -> int:
    """For how long an answer is waited for in a fleet of so many robots."""
    return max(ASK_TIMEOUT_MS, ASK_TIMEOUT_MS_PER_ROBOT * robots)


def connect_s(robots: int) -> float:
    """For how long a process of a fleet of so many robots tries to get its first session [wall s]."""
    return CONNECT_S * (1 + robots // ROBOTS_PER_CONNECT)


def client_settings(session: Session) -> Json:
    """For a robot or the world: one link to a router; once established, it is retried for ever.

    At first each router is tried once. With a time-out Zenoh tries the first one again and again until that
    has passed, and never the second.
    """
    settings = _common(session.robots) | {
        "mode": "client",
        "connect": {
            "endpoints": list(session.endpoints),
            "timeout_ms": 0,
            "retry": RETRY,
        },
        "listen": {"endpoints": []},
        "queries_default_timeout": ask_timeout_ms(session.robots),
    }
    if session.password is not None:
        settings["transport"]["auth"] = {"usrpwd": {"user": session.user, "password": session.password}}
    return settings


def router_settings(session: RouterSession, folder: Path, number: int = 1) -> Json:
    """For the first or the second router: users from the folder's file, access by the rules."""
    asks = number > 1  # `protocol.network.interlink`
    access, first = access_rules(session.fleet_keys), session.first
    if first is not None:
        access = with_other_router(access, session.fleet_keys, first, asks=asks)
    settings = _common(session.robots) | {
        "mode": "router",
        "listen": {"endpoints": [session.endpoints[number - 1]], "exit_on_failure": True},
        "connect": {
            "endpoints": [session.endpoints[0]] if asks else [],
            "timeout_ms": -1,  # for ever; a router serves alone while the other is away
            "exit_on_failure": False,
            "retry": RETRY,
        },
        "access_control": access,
        **({"id": first} if first is not None and not asks else {}),
    }
    user = {"user": ROUTER, "password": session.password} if asks else {}
    settings["transport"]["auth"] = {"usrpwd": {"dictionary_file": str(folder / USERS_FILE), **user}}
    settings["transport"]["unicast"] |= {"max_sessions": SESSIONS_MAX, "accept_pending": SESSIONS_MAX}
    return settings


def _common(robots: int) -> Json:
    return {
        "scouting": {"delay": 0, "multicast": {"enabled": False}, "gossip": {"enabled": False}},
        "timestamping": {"enabled": True, "drop_future_timestamp": False},
        "transport": {
            "shared_memory": {"enabled": False},
            "unicast": {"open_timeout": OPEN_TIMEOUT_MS, "accept_timeout": OPEN_TIMEOUT_MS, "max_links": 1},
            "link": {
                "tx": {
                    "lease": lease_ms(robots),
                    "keep_alive": 4,
                    "queue": {"size": {"data": QUEUE_BATCHES}},
                },
                # Twice a message's limit: key and header are added, and the codec checks the exact limit.
                "rx": {"max_message_size": 2 * SIZE_MAX_BYTES},
            },
        },
    }
