"""Whether a session is connected and no longer hears any process. Pure: times are arguments. Liveness only.

When Zenoh gives up opening a link just after the other side has accepted it, the link stays half open: the
session counts as connected, receives nothing, and the router refuses it any other link (`MAX_LINKS`).

Rule 1: a session is deaf if it is connected and has seen no token of another process for `DEAF_S`. It is
        opened anew. If the others are really gone, that costs some milliseconds.
Rule 2: a pause of this process counts as `LOOK_S_MAX` at most: what has arrived meanwhile is not read yet.
Rule 3: the time doubles, up to `DEAF_S_MAX`, until a token is seen. It is as long before the first one: the
        others may not have been started yet.
"""

from collections.abc import Collection

from protocol.keys import matches

DEAF_S = 0.6  # wall: less than the silence after which the world takes robots for dead (world/attendance.py)
DEAF_S_MAX = 10.0  # wall
LOOK_S_MAX = 0.2  # wall: a process looks at least every 0.1 s


class Deafness:
    """The tokens that one session sees."""

    def __init__(self, own: str | None) -> None:
        """`own` is the key of the session's own token, which it sees without the router."""
        self._own = own
        self._shown: set[str] = set()
        self._limit_s = DEAF_S_MAX
        self._alone_s = 0.0
        self._looked_s: float | None = None

    @property
    def is_alone(self) -> bool:
        """Whether it sees no token of another process."""
        return self._shown <= {self._own}

    def see(self, key: str, *, shown: bool) -> None:
        """A token has appeared or vanished."""
        if not shown:
            self._shown.discard(key)
            return
        self._shown.add(key)
        if key != self._own:
            self._alone_s, self._limit_s = 0.0, DEAF_S

    def forget_others(self, patterns: Collection[str]) -> None:
        """From now on only tokens on these patterns are watched."""
        self._shown = {key for key in self._shown if any(matches(each, key) for each in patterns)}

    def look(self, now_s: float, *, connected: bool) -> bool:
        """Call it often while it is alone; returns whether the session is to be opened anew now."""
        passed_s = 0.0 if self._looked_s is None else min(now_s - self._looked_s, LOOK_S_MAX)
        self._looked_s = now_s
        self._alone_s = self._alone_s + passed_s if connected and self.is_alone else 0.0
        if self._alone_s < self._limit_s:
            return False
        self._alone_s = 0.0
        self._limit_s = min(2.0 * self._limit_s, DEAF_S_MAX)
        return True

    def forget(self) -> list[str]:
        """A new session begins; returns the tokens that the old one saw."""
        shown = sorted(self._shown)
        self._shown.clear()
        return shown
