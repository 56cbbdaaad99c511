"""Zenoh's settings for the fleet's processes and for its router. Pure; figures are of zenoh.md.

Rule 1: nothing is found by scouting, nothing goes through shared memory (it would write payloads, in
        plain, to /dev/shm), and nobody is admitted without a password where the router is ours.
"""

from pathlib import Path

from protocol.access import Json, access_rules
from protocol.codec import SIZE_MAX_BYTES
from protocol.frames import ROBOTS_MAX
from protocol.session import USERS_FILE, RouterSession, Session

LEASE_MS = 1000  # 200 ms gave false deaths on a loaded machine, 500 ms and more none
OPEN_TIMEOUT_MS = 1000  # the default, 10 s, is how long a frozen router would hold us up
CONNECT_TIMEOUT_MS = 5000  # a router that was started before us listens within a second
ASK_TIMEOUT_MS = 1000
QUEUE_BATCHES = 16  # Zenoh's most, made when needed; DROP drops what finds no room within 1 ms
SESSIONS_MAX = ROBOTS_MAX + 500  # and room for their successors


def client_settings(session: Session) -> Json:
    """For a robot or the world: one link, to the router, that is retried for ever once it has been up."""
    settings = _common() | {
        "mode": "client",
        "connect": {
            "endpoints": [session.endpoint],
            "timeout_ms": CONNECT_TIMEOUT_MS,
            "retry": {"period_init_ms": 100, "period_max_ms": 500, "period_increase_factor": 1.5},
        },
        "listen": {"endpoints": []},
        "queries_default_timeout": ASK_TIMEOUT_MS,
    }
    if session.password is not None:
        settings["transport"]["auth"] = {"usrpwd": {"user": session.user, "password": session.password}}
    return settings


def router_settings(session: RouterSession, folder: Path) -> Json:
    """For the fleet's router: admits whom the folder's users file names, allows what the rules name."""
    settings = _common() | {
        "mode": "router",
        "listen": {"endpoints": [session.endpoint], "exit_on_failure": True},
        "connect": {"endpoints": []},
        "access_control": access_rules(session.keys, robots=session.robots),
    }
    settings["transport"]["auth"] = {"usrpwd": {"dictionary_file": str(folder / USERS_FILE)}}
    settings["transport"]["unicast"] |= {"max_sessions": SESSIONS_MAX, "accept_pending": SESSIONS_MAX}
    return settings


def _common() -> Json:
    return {
        "scouting": {"delay": 0, "multicast": {"enabled": False}, "gossip": {"enabled": False}},
        "timestamping": {"enabled": True, "drop_future_timestamp": True},
        "transport": {
            "shared_memory": {"enabled": False},
            "unicast": {"open_timeout": OPEN_TIMEOUT_MS, "accept_timeout": OPEN_TIMEOUT_MS, "max_links": 1},
            "link": {
                "tx": {
                    "lease": LEASE_MS,
                    "keep_alive": 4,
                    "queue": {"size": {"data": QUEUE_BATCHES}},
                },
                # Twice a message's limit: key and header come on top, and the codec is exact.
                "rx": {"max_message_size": 2 * SIZE_MAX_BYTES},
            },
        },
    }
