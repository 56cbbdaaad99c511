"""What may be asked of the viewer, and how it is answered. Pure: no socket.

Rule 1: it answers GET, and only what is in its site by exactly that path: no path of a file is ever made of
        what somebody asks for.
Rule 2: it answers only who calls it by its own address. A page of another origin whose name has been
        re-pointed to us (DNS rebinding) calls us by that name, and is refused.
Rule 3: it answers nothing that a page of another origin has its browser ask for: not even that it is there.
        A link may lead to us from anywhere.
Rule 4: nothing is said that would let another origin read an answer, and a page of ours loads from us alone.
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
    """An answer that is whole from the beginning."""

    body: bytes
    content_type: str = "text/html; charset=utf-8"
    policy: str = "default-src 'none'"
    """The Content-Security-Policy."""
    status: HTTPStatus = HTTPStatus.OK


@dataclass(frozen=True, slots=True)
class Telling:
    """An answer that goes on: what is told of a run, behind the message that the page has seen last."""

    run: int
    newest_id: str | None


Site = Mapping[str, Document | int]
"""By path, without a query; a number: what is told of that run, counted from 0."""


def hosts_of(port: int) -> frozenset[bytes]:
    """By what names we may be called."""
    return frozenset(f"{name}:{port}".encode() for name in ("127.0.0.1", "localhost"))


def answer(request: h11.Request, site: Site, hosts: frozenset[bytes]) -> Document | Telling:
    """What is said to a request."""
    headers = dict(request.headers)
    if headers.get(b"host") not in hosts:
        return refusal(HTTPStatus.MISDIRECTED_REQUEST)
    if not _is_of_ours(headers):
        return refusal(HTTPStatus.FORBIDDEN)
    if request.method != b"GET":
        return Document(b"", status=HTTPStatus.METHOD_NOT_ALLOWED)  # HEAD is one of them, and has no body
    found = site.get(request.target.partition(b"?")[0].decode("latin-1"))
    if found is None:
        return refusal(HTTPStatus.NOT_FOUND)
    if isinstance(found, int):
        newest_id = headers.get(b"last-event-id")
        return Telling(found, None if newest_id is None else newest_id.decode("latin-1"))
    return found


def _is_of_ours(headers: Mapping[bytes, bytes]) -> bool:
    """Whether our page asks, or the user: a browser says so, and a page cannot have it say otherwise."""
    if headers.get(b"sec-fetch-site", b"none") in {b"same-origin", b"none"}:
        return True
    return headers.get(b"sec-fetch-mode") == b"navigate" and headers.get(b"sec-fetch-dest") == b"document"


def refusal(status: HTTPStatus) -> Document:
    """Why a request is not answered."""
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
