"""The books of a run: what was sent, what was received, and what is accounted for by nothing.

Rule 1: a key has one sender; each of its receivers is a book of its own: `muster` has all other robots.
Rule 2: odometry flows on while robots count, so its book is closed at the newest that the robot received.
Rule 3: where one side never told its counts (it died), the book is left out and named.
Rule 4: the recorder's keys are not in the books: entries have numbers, re-sending and completeness of
        their own; nor are queries.
"""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass

from msgspec import Struct

from protocol.keys import WORLD, robot_name


class Messages(Struct, frozen=True, kw_only=True):
    """What became of the messages of a run."""

    sent: int
    received: int
    injected: dict[str, int]
    """Messages that a fault plan took away, by kind."""
    unaccounted: int
    left_out: tuple[str, ...]
    """Books that have only one side, as `key > receiver`."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Account:
    """What one source counted, by the part of the key behind the run's root."""

    sent: Mapping[str, int]
    received: Mapping[str, int]
    newest: Mapping[str, int]


def balance(accounts: Mapping[str, Account], *, robots: Sequence[int]) -> Messages:
    """Balance the books of all sources that told their counts; the world is one of them."""
    sent = received = 0
    left_out: list[str] = []
    told = {key for account in accounts.values() for key in (*account.sent, *account.received)}
    for key in sorted(told):
        for sender, receiver in _ends(key, robots):
            if sender not in accounts or receiver not in accounts:
                left_out.append(f"{key} > {receiver}")
                continue
            heard = accounts[receiver]
            received += heard.received.get(key, 0)
            sent += (heard.newest if sender == WORLD else accounts[sender].sent).get(key, 0)
    return Messages(
        sent=sent, received=received, injected={}, unaccounted=sent - received, left_out=tuple(left_out)
    )


def _ends(key: str, robots: Sequence[int]) -> Iterator[tuple[str, str]]:
    """The sender of a key and each of its receivers; nobody where the key is not in the books."""
    match key.split("/"):
        case ["link", sender, receiver]:
            yield sender, receiver
        case ["body", robot, "drive"]:
            yield robot, WORLD
        case ["body", robot, "odometry"]:
            yield WORLD, robot
        case ["muster", sender]:
            yield from ((sender, name) for name in map(robot_name, robots) if name != sender)
        case _:
            pass
