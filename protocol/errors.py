"""Errors by whose fault they are: the user's or a peer's. Our own faults are assertions."""


class ClewError(Exception):
    """Whatever Clew raises on purpose."""


class UsageError(ClewError):
    """The user asked for something that cannot be: one clear line, exit code 2."""


class SessionLostError(ClewError):
    """Zenoh has given up this process's session, which can neither speak nor hear: the process ends."""


class MessageRefusedError(ClewError):
    """A peer sent what breaks the protocol: counted, logged with its sender, dropped."""
