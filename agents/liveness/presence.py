"""Which processes show a liveliness token, as one robot sees it. Pure.

Rule 1: a token that has gone, or has come back as another process's, ends nothing by itself: a process
        that is heard of after that lives on.
Rule 2: a robot that does not see the world's token is cut off itself, and knows nothing of the others. When
        it sees that again, the tokens of the others may be on their way: they count as gone from then on.
Rule 3: a live robot watches only the tokens that matter to it: all tokens for all robots are a square. What
        it knew of the others is void. A robot that it begins to watch and that shows none has gone by then.
"""

from collections.abc import Iterable

from protocol.keys import WORLD_NUMBER

GRACE_S = 0.35  # a heartbeat takes 0.25 s, a router that fails over 12 ms; no multiple of odometry periods


class Presence:
    """The tokens of a run."""

    def __init__(self) -> None:
        self._tokens: dict[int, tuple[str, ...]] = {}
        self._newest: dict[int, str] = {}
        self._went_s: dict[int, float] = {}
        """When a robot's last process stopped showing its token."""
        self.sees_all = True
        """Whether all tokens that are shown have been seen."""
        self._listed_s: float | None = None
        """When those of all robots were seen that this robot had not watched before (rule 3)."""

    def come(self, robot: int, incarnation: str, now_s: float) -> None:
        """A token has come."""
        if self._newest.get(robot, incarnation) == incarnation:
            self._went_s.pop(robot, None)
        else:
            self._went_s.setdefault(robot, now_s)  # another process: the one before is no more
        self._newest[robot] = incarnation
        others = tuple(other for other in self._tokens.get(robot, ()) if other != incarnation)
        if robot == WORLD_NUMBER and not self.connected:
            self._went_s.update((other, now_s) for other in self._went_s if not self.shows(other))
        self._tokens[robot] = (*others, incarnation)

    def see(self, shown: Iterable[tuple[int, str]], now_s: float) -> None:
        """Tokens of several robots have come."""
        for robot, incarnation in shown:
            self.come(robot, incarnation, now_s)

    def watch(self, robots: Iterable[int] | None, now_s: float) -> None:
        """Rule 3: the tokens of these robots are watched, or of all, and those that are shown have come."""
        self.sees_all = robots is None
        self._listed_s = now_s if self.sees_all else None
        if robots is None:
            return
        watched = {*robots, WORLD_NUMBER}
        for known in (self._tokens, self._newest, self._went_s):
            for robot in known.keys() - watched:
                del known[robot]
        for robot in watched - {WORLD_NUMBER}:
            if not self.shows(robot):
                self._went_s.setdefault(robot, now_s)

    def go(self, robot: int, incarnation: str, now_s: float) -> None:
        """A token has gone."""
        left = tuple(other for other in self._tokens.get(robot, ()) if other != incarnation)
        self._tokens[robot] = left
        if not left:
            self._went_s[robot] = now_s

    @property
    def connected(self) -> bool:
        """Rule 2."""
        return self.shows(WORLD_NUMBER)

    def shows(self, robot: int) -> bool:
        """Whether a robot shows one."""
        return bool(self._tokens.get(robot))

    def was_seen(self, robot: int) -> bool:
        """Whether a robot has ever shown one."""
        return robot in self._newest

    def has_gone_by(self, robot: int, at_s: float) -> bool:
        """Whether a robot has shown no token since then, or this one has never seen any."""
        return not self.shows(robot) and self._went_s.get(robot, at_s) <= at_s

    def is_lost(self, robot: int, heard_at_s: float, now_s: float) -> bool:
        """Rule 1: whether the process is no more that was last heard then."""
        went_s = self._went_s.get(robot)
        if went_s is None and self._listed_s is not None and not self.shows(robot):
            went_s = self._listed_s
        if went_s is None or not self.connected:
            return False
        if self.shows(robot):
            # Both times are those of an odometry: heard at the same one, it was the process before.
            return heard_at_s <= went_s and now_s >= went_s + GRACE_S
        return now_s >= max(went_s, heard_at_s) + GRACE_S
