"""A process for tests to kill: declares a token over real Zenoh, then waits for ever or raises."""

import asyncio
import sys
from pathlib import Path

from protocol.network.session import read_session
from protocol.network.zenoh_transport import open_transport


async def main(path: Path, *, breaks: bool) -> None:
    """Subscribe, declare a token, print `alive`; then raise if asked to."""
    session = read_session(path)
    keys = session.keys
    with open_transport(
        session,
        hear=[keys.link("*", session.name)],
        answer=[],
        alive=keys.alive(session.name, "child"),
        watch=(),
    ) as transport:
        print("alive", flush=True)  # noqa: T201 - what the test waits for
        if breaks:
            raise RuntimeError("broken on purpose")
        await transport.arrivals(None)


if __name__ == "__main__":
    asyncio.run(main(Path(sys.argv[1]), breaks=sys.argv[2:] == ["breaks"]))
