"""Errors by their cause: the user or a peer. Errors of our own are assertions."""


class ClewError(Exception):
    """The base class of all exceptions that Clew raises on purpose."""


class UsageError(ClewError):
    """The user asked for something impossible: one clear line, exit code 2."""


class SessionLostError(ClewError):
    """This process's Zenoh session is lost. It can neither send nor receive, so the process ends."""


class MessageRefusedError(ClewError):
    """A peer's message breaks the protocol: it is counted, logged with its sender, and dropped."""
