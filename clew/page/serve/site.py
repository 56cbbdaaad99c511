"""The permitted requests to the viewer, and its answers. Pure: no socket.

Rule 1: it answers only GET, and only the exact paths of its site. A request never becomes a file's path.
Rule 2: it answers only requests to its own address. A page of another origin whose name points to us (DNS
        rebinding) uses that name, and is refused.
Rule 3: it refuses all requests that a page of another origin makes, so such a page cannot detect it. Links to
        us may be anywhere.
Rule 4: no header allows another origin to read an answer, and our pages load only from us.
"""

from collections.abc import Mapping
from dataclasses import dataclass
from http import HTTPStatus

import h11

HEAD_BYTES_MAX = 16_384  # of a request; browsers send less than 2,000 bytes

HEADERS = (
    ("Cache-Control", "no-store"),
    ("Connection", "close"),
    ("Cross-Origin-Resource-Policy", "same-origin"),
    ("Referrer-Policy", "no-referrer"),
    ("X-Content-Type-Options", "nosniff"),
)


@dataclass(frozen=True, slots=True)
class Document:
    """An answer that is complete from the beginning."""

    body: bytes
    content_type: str = "text/html; charset=utf-8"
    policy: str = "default-src 'none'"
    """The Content-Security-Policy."""
    status: HTTPStatus = HTTPStatus.OK


@dataclass(frozen=True, slots=True)
class Telling:
    """A continuing answer: the messages of a run after the last one that the page has seen."""

    run: int
    newest_id: str | None


Site = Mapping[str, Document | int]
"""By path, without a query; a number is the feed of that run, counted from 0."""


def hosts_of(port: int) -> frozenset[bytes]:
    """The host names that requests may use."""
    return frozenset(f"{name}:{port}".encode() for name in ("127.0.0.1", "localhost"))


def answer(request: h11.Request, site: Site, hosts: frozenset[bytes]) -> Document | Telling:
    """The answer to a request."""
    headers = dict(request.headers)
    if headers.get(b"host") not in hosts:
        return refusal(HTTPStatus.MISDIRECTED_REQUEST)
    if not _is_of_ours(headers):
        return refusal(HTTPStatus.FORBIDDEN)
    if request.method != b"GET":
        return Document(b"", status=HTTPStatus.METHOD_NOT_ALLOWED)  # including HEAD, whose answer has no body
    found = site.get(request.target.partition(b"?")[0].decode("latin-1"))
    if found is None:
        return refusal(HTTPStatus.NOT_FOUND)
    if isinstance(found, int):
        newest_id = headers.get(b"last-event-id")
        return Telling(found, None if newest_id is None else newest_id.decode("latin-1"))
    return found


def _is_of_ours(headers: Mapping[bytes, bytes]) -> bool:
    """Whether the request comes from our page or the user: the browser tells, and no page can fake it."""
    if headers.get(b"sec-fetch-site", b"none") in {b"same-origin", b"none"}:
        return True
    return headers.get(b"sec-fetch-mode") == b"navigate" and headers.get(b"sec-fetch-dest") == b"document"


def refusal(status: HTTPStatus) -> Document:
    """The refusal of a request."""
    return Document(f"{status} {status.phrase}\n".encode(), "text/plain; charset=utf-8", status=status)


def head(said: Document | Telling) -> h11.Response:
    """The head of an answer."""
    if isinstance(said, Telling):
        headers = [*HEADERS, ("Content-Type", "text/event-stream")]
        return h11.Response(status_code=HTTPStatus.OK, headers=headers)
    headers = [
        *HEADERS,
        ("Content-Type", said.content_type),
        ("Content-Length", str(len(said.body))),
        ("Content-Security-Policy", said.policy),
    ]
    if said.status is HTTPStatus.METHOD_NOT_ALLOWED:
        headers.append(("Allow", "GET"))
    return h11.Response(status_code=said.status, reason=said.status.phrase.encode(), headers=headers)
