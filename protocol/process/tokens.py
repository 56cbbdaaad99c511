"""What a process sees of the liveliness tokens of others, one by one."""

from msgspec import Struct


class TokenCame(Struct, frozen=True, gc=False):
    """The liveliness token of a process has appeared; robot 0 is the world."""

    robot: int
    incarnation: str


class TokenWent(Struct, frozen=True, gc=False):
    """A liveliness token has gone: the process died, is frozen or cut off; or the observer is cut off."""

    robot: int
    incarnation: str
