"""The fleet's router: Zenoh in mode router, inside this process, with the fleet's access rules. A shell."""

import contextlib
import json
import re
from collections.abc import Iterator
from pathlib import Path

import zenoh

from protocol.errors import UsageError
from protocol.network.session import RouterSession, check_endpoint
from protocol.network.settings import router_settings

ZENOH_SOURCE = re.compile(r" at /\S+\.rs:\d+\.?")  # Zenoh's errors end with a line of its own source


@contextlib.contextmanager
def open_router(session: RouterSession, folder: Path, number: int = 1) -> Iterator[None]:
    """Run the fleet's router with this number while the context is open.

    Zenoh locks the path of a Unix socket, so a second router cannot take it from a running one.

    Raises:
        UsageError: the endpoint is taken or unusable.
    """
    endpoint = session.endpoints[number - 1]
    check_endpoint(endpoint)
    config = zenoh.Config.from_json5(json.dumps(router_settings(session, folder, number)))
    try:
        router = zenoh.open(config)
    except zenoh.ZError as error:
        reason = ZENOH_SOURCE.sub("", str(error))
        raise UsageError(f"cannot listen at {endpoint.partition('#')[0]}: {reason}") from error
    with router:
        yield
