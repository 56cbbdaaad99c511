"""The fleet's router: Zenoh in mode router, inside this process, with the fleet's access rules. A shell."""

import contextlib
import json
import re
from collections.abc import Iterator
from pathlib import Path

import zenoh

from protocol.errors import UsageError
from protocol.session import RouterSession, check_endpoint
from protocol.settings import router_settings

ZENOH_SOURCE = re.compile(r" at /\S+\.rs:\d+\.?")  # Zenoh's errors end in a line of its own source


@contextlib.contextmanager
def open_router(session: RouterSession, folder: Path) -> Iterator[None]:
    """Listen at the session's endpoint for as long as the context lasts.

    Zenoh locks a Unix socket's path, so a second router cannot steal it from one that lives.

    Raises:
        UsageError: the endpoint is taken or will not do.
    """
    check_endpoint(session.endpoint)
    config = zenoh.Config.from_json5(json.dumps(router_settings(session, folder)))
    try:
        router = zenoh.open(config)
    except zenoh.ZError as error:
        reason = ZENOH_SOURCE.sub("", str(error))
        raise UsageError(f"cannot listen at {session.endpoint}, is it taken? {reason}") from error
    with router:
        yield
