"""The session of a process: its fleet, run and name, the router, its password.

Rule 1: each run has new passwords, in a folder that only its owner can read.
Rule 2: a session without a password is for a router that the user runs (`--connect`).
"""

import os
import re
import secrets
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Annotated, TypeVar

import msgspec
from msgspec import Meta, Struct

from protocol.errors import UsageError
from protocol.files.names import did_you_mean
from protocol.files.opening import read_bytes
from protocol.files.writing import write_whole
from protocol.frames import ROBOTS_MAX
from protocol.keys import WORLD, Keys, robot_name
from protocol.network.access import user_name
from protocol.network.interlink import ID_BITS, ROUTER

Chunk = Annotated[str, Meta(pattern=r"\A[A-Za-z0-9_.-]{1,64}\Z")]  # one chunk of a key, no wildcard
ENDPOINT = r"\A[a-z-]+/\S+\Z"  # Zenoh's: a protocol and an address
ROUTER_ID = r"\A[1-9a-f][0-9a-f]{0,31}\Z"  # Zenoh refuses one that begins with 0
ENDPOINT_CHARS_MAX = 1000  # room for the absolute paths of five files
Endpoint = Annotated[str, Meta(pattern=ENDPOINT, max_length=ENDPOINT_CHARS_MAX)]

T = TypeVar("T")

ROUTERS_MAX = 2  # one carries the fleet; the other takes over when it dies
TLS = "tls/"
CERTIFIED = (TLS, "quic/")  # the protocols of Zenoh that use certificates
TLS_CONTENTS = (
    "root_ca_certificate",
    "listen_private_key",
    "listen_certificate",
    "connect_private_key",
    "connect_certificate",
)
TLS_SETTINGS = frozenset(
    [f"{content}_{form}" for content in TLS_CONTENTS for form in ("file", "base64")]
    + ["enable_mtls", "verify_name_on_connect", "close_link_on_expiration"]
)
LINK_SETTINGS = frozenset({"bind", "dscp", "iface", "so_rcvbuf", "so_sndbuf"})  # of any link over TCP
UNIX_SOCKET = "unixsock-stream/"
UNIX_SOCKET_PATH_BYTES_MAX = 107  # sockaddr_un of Linux: 108 with the closing NUL
ROUTER_FILE = "router.json"
USERS_FILE = "users"
SESSION_BYTES_MAX = 1 << 20  # a session takes some hundred, the router's 200 bytes for each robot
INPUTS_BYTES_MAX = 1 << 28  # packed: more than half an hour of scans of 1440 rays (13 kB) every 0.1 s
INPUTS = "inputs"  # a subfolder of the run's folder: the inputs and decisions of the robots


class Session(Struct, frozen=True, kw_only=True):
    """The parameters of one process for opening its transport."""

    fleet: Chunk
    run: Chunk
    name: Chunk
    robots: Annotated[int, Meta(ge=1, le=ROBOTS_MAX)] = 1
    """How many robots share its routers: those of all fleets of its run."""
    endpoints: Annotated[tuple[Endpoint, ...], Meta(min_length=1)]
    """The endpoints of all routers; any of them can be used."""
    user: str | None = None
    password: str | None = None
    inputs: str | None = None
    """The folder for the inputs and decisions of robots; they are not kept if it is None or missing."""
    inputs_bytes_max: Annotated[int, Meta(ge=1)] = INPUTS_BYTES_MAX
    """How much of them each process keeps, packed: their beginning."""

    @property
    def keys(self) -> Keys:
        """The keys of its run."""
        return Keys(self.fleet, self.run)

    @property
    def no_link(self) -> str:
        """Why it may have no link to a router: Zenoh does not tell which it is."""
        addresses = [endpoint.partition("#")[0] for endpoint in self.endpoints]  # settings of Zenoh follow
        wants = f"refuses the password of {self.name}"
        if self.password is None:
            wants = "wants a password: there is none with --connect"
        if any(address.startswith(CERTIFIED) for address in addresses):
            wants += ", or a certificate is refused (expired, of another address, or of another root)"
        return f"no router answers at {' or '.join(addresses)}, or it {wants}"


class RouterSession(Struct, frozen=True, kw_only=True):
    """The parameters of a run's routers: the processes to admit, and the endpoints."""

    run: Chunk
    fleets: Annotated[dict[Chunk, Annotated[int, Meta(ge=1, le=ROBOTS_MAX)]], Meta(min_length=1)]
    """How many robots each fleet has."""
    endpoints: Annotated[tuple[Endpoint, ...], Meta(min_length=1, max_length=ROUTERS_MAX)]
    """The endpoint of each router, in order."""
    first: Annotated[str, Meta(pattern=ROUTER_ID)] | None = None
    """The Zenoh id of the first router; None if there is only one router."""
    password: str | None = None
    """The password of the second router at the first."""

    @property
    def robots(self) -> int:
        """How many robots all fleets have."""
        return sum(self.fleets.values())

    @property
    def fleet_keys(self) -> dict[Keys, int]:
        """How many robots each fleet has, by its keys."""
        return {Keys(fleet, self.run): robots for fleet, robots in self.fleets.items()}


@dataclass(frozen=True, slots=True, kw_only=True)
class Crew:
    """One fleet of a run: its sessions are to be written."""

    fleet: str
    robots: int
    sessions: Path
    """The folder for the sessions of its world and its robots."""
    inputs: Path | None = None
    inputs_bytes_max: int = INPUTS_BYTES_MAX


def unix_socket_endpoint(folder: Path, number: int = 1) -> str:
    """The default endpoint of a run's router: a socket in the run's own folder, no port."""
    name = "router.sock" if number == 1 else f"router-{number}.sock"
    return f"{UNIX_SOCKET}{folder.resolve() / name}"


def write_sessions(
    folder: Path,
    *,
    fleet: str,
    run: str,
    robots: int,
    endpoints: Sequence[str],
    passwords: bool = True,
    inputs: Path | None = None,
    inputs_bytes_max: int = INPUTS_BYTES_MAX,
) -> None:
    """Write the sessions of a run with one fleet, as `write_all_sessions`."""
    crew = Crew(fleet=fleet, robots=robots, sessions=folder, inputs=inputs, inputs_bytes_max=inputs_bytes_max)
    write_all_sessions(folder, [crew], run=run, endpoints=endpoints, passwords=passwords)


def write_all_sessions(
    folder: Path,
    crews: Sequence[Crew],
    *,
    run: str,
    endpoints: Sequence[str],
    passwords: bool = True,
) -> None:
    """Write `world.json`, `r1.json`, ... of each fleet and, with passwords, the files of our own routers.

    Raises:
        UsageError: a name, an endpoint or the folder is unusable.
    """
    for endpoint in endpoints:
        check_endpoint(endpoint)
    try:
        router = _router_session(crews, run, endpoints, are_two=passwords and len(endpoints) > 1)
        for each in (folder, *(crew.sessions for crew in crews)):
            each.mkdir(mode=0o700, parents=True, exist_ok=True)
            each.chmod(0o700)
        users = [] if router.password is None else [f"{ROUTER}:{router.password}\n"]
        for crew in crews:
            for name in (WORLD, *map(robot_name, range(1, crew.robots + 1))):
                session = _session(crew, name, router, has_password=passwords)
                write_whole(crew.sessions / f"{name}.json", msgspec.json.encode(session))
                users.append(f"{session.user}:{session.password}\n")
        if passwords:
            write_whole(folder / ROUTER_FILE, msgspec.json.encode(router))
            write_whole(folder / USERS_FILE, "".join(users).encode())
    except (OSError, msgspec.ValidationError) as error:
        raise UsageError(f"cannot write sessions into {folder}: {error}") from error


def _router_session(
    crews: Sequence[Crew], run: str, endpoints: Sequence[str], *, are_two: bool
) -> RouterSession:
    return msgspec.convert(
        {
            "run": run,
            "fleets": {crew.fleet: crew.robots for crew in crews},
            "endpoints": endpoints,
            "first": f"{secrets.randbits(ID_BITS) | 1 << (ID_BITS - 1):x}" if are_two else None,
            "password": _new_password() if are_two else None,
        },
        RouterSession,
    )


def _session(crew: Crew, name: str, router: RouterSession, *, has_password: bool) -> Session:
    return Session(
        fleet=crew.fleet,
        run=router.run,
        name=name,
        robots=router.robots,
        endpoints=router.endpoints,
        user=user_name(Keys(crew.fleet, router.run), name) if has_password else None,
        password=_new_password() if has_password else None,
        inputs=None if crew.inputs is None else str(crew.inputs),
        inputs_bytes_max=crew.inputs_bytes_max,
    )


def _new_password() -> str:
    return secrets.token_urlsafe(24)


def read_session(path: Path) -> Session:
    """Read a session that `write_sessions` wrote.

    Raises:
        UsageError: the file is missing or invalid.
    """
    return _read(path, Session)


def read_router_session(folder: Path) -> RouterSession:
    """Read the routers' session from a folder that `write_sessions` wrote.

    Raises:
        UsageError: the file is missing or invalid.
    """
    return _read(folder / ROUTER_FILE, RouterSession)


def check_endpoint(endpoint: str) -> None:
    """Refuse an endpoint that Zenoh or the kernel would refuse, with a clearer message.

    Rule 1 (security): a setting that would protect nothing is refused. Zenoh passes over names that it does
    not know, and over settings of TLS on another link.

    Raises:
        UsageError: it is not an endpoint, the path of its Unix socket is too long, a file that it names
            cannot be read, or a setting would have no effect.
    """
    if not re.search(ENDPOINT, endpoint):
        raise UsageError(f"an endpoint looks like tcp/127.0.0.1:7447, not like {endpoint!r}")
    if len(endpoint) > ENDPOINT_CHARS_MAX:
        raise UsageError(f"an endpoint may have {ENDPOINT_CHARS_MAX} characters, not {len(endpoint)}")
    address, _, settings = endpoint.partition("#")
    for setting in filter(None, settings.split(";")):
        name, _, value = setting.partition("=")
        _check_setting(address, name, value)
    path = endpoint.removeprefix(UNIX_SOCKET)
    size_bytes = len(os.fsencode(path))
    if path != endpoint and size_bytes > UNIX_SOCKET_PATH_BYTES_MAX:
        raise UsageError(
            f"a socket's path may have {UNIX_SOCKET_PATH_BYTES_MAX} bytes, not {size_bytes}: {path}"
        )


def _check_setting(address: str, name: str, value: str) -> None:
    if address.startswith(TLS) and name not in TLS_SETTINGS | LINK_SETTINGS:
        names = sorted(TLS_SETTINGS | LINK_SETTINGS)
        raise UsageError(f"{address} has no setting {name!r}{did_you_mean(name, names)}")
    if name in TLS_SETTINGS and not address.startswith(CERTIFIED):
        raise UsageError(f"{name} is a setting of tls/, and {address} is not encrypted")
    if name in TLS_SETTINGS and name.endswith("_file"):
        try:
            read_bytes(Path(value), SESSION_BYTES_MAX)
        except OSError as error:
            raise UsageError(f"{name}={value}: {error.strerror}") from error


def _read(path: Path, kind: type[T]) -> T:
    try:
        return msgspec.json.decode(read_bytes(path, SESSION_BYTES_MAX), type=kind)
    except (OSError, ValueError) as error:
        raise UsageError(f"no session in {path}: {error}") from error
