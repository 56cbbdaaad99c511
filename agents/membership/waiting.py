"""Who keeps the others waiting in a lining up, as one robot sees it. Pure.

Rule 1: before there is a turn: who has not looked at its leg.
Rule 2: in a turn, from when it may be driven: who has it and stands for long, or is slow; but where another
        has not answered it for most of the time, it is that one, since the first may not drive then.
Rule 3: where nobody has a turn: who has to give the next one; when all are in place, who does not say so, or
        who has to lead.
"""

from collections import defaultdict

from agents.membership.muster import Roster
from protocol.mission import Mission
from protocol.wire.messages import Turn

STALLS_S = 20.0  # a decimetre takes 0.2 s, and a turn on the spot two
SLOW_S = 10.0  # to look takes a second, with half of all messages lost three
SLOW_SHARE = 0.4  # of the speed, on average: robots join through corridors at 0.5 of it, and at 0.24
# where they miss 6 of 7 messages (seeds 5784 and 2394 of a swarm).


class Waiting:
    """How long the members of one lining up have kept one robot waiting."""

    def __init__(self, robot: int, mission: Mission, roster: Roster, now_s: float) -> None:
        self._robot = robot
        self._mission = mission
        self._roster = roster
        self._began_s = self._noted_s = self._turn_s = self._made_s = now_s
        self._made: tuple[Turn, float] | None = None
        """The newest turn, and how far it has been driven; since when, `_turn_s` and `_made_s`."""
        self._away_s: defaultdict[int, float] = defaultdict(float)
        """For how long a robot has not answered that turn."""
        self._idle: tuple[Turn | None, tuple[int, ...]] | None = None
        """Between two turns: the last one, and who is in place; since when, `_idle_s`."""
        self._idle_s = now_s

    def note(self, now_s: float) -> None:
        """Take in who answers the turn at this moment; to be called again and again."""
        turn, passed_s = self._roster.turn, now_s - self._noted_s
        self._noted_s = now_s
        if turn is None:
            return
        for robot, muster in self._roster.heard.items():
            answers = muster.turn >= turn.number and muster.echo_s >= now_s - self._mission.silence_s
            if robot not in {turn.robot, self._robot} and not answers:
                self._away_s[robot] += passed_s

    def stalled(self, now_s: float, *, free_at_s: float | None, late_s: float) -> int | None:
        """Who it is, if anybody.

        Args:
            now_s: the time.
            free_at_s: when robots may drive; None: that is not known yet.
            late_s: for how much longer to wait than others do.
        """
        turn, may_drive = self._roster.turn, free_at_s is not None and now_s >= free_at_s
        blind = self._blind() if turn is None and now_s - self._began_s > SLOW_S + late_s else None
        if blind is not None:
            return blind
        mover = self._roster.heard.get(turn.robot) if turn is not None else None
        if turn is None or mover is None or mover.ended >= turn.number:
            self._made = None
            return self._idler(now_s, STALLS_S + late_s, may_drive=may_drive)
        self._idle, made = None, (turn, mover.made_m)
        if not may_drive or self._made is None or self._made[0] != turn:
            self._turn_s = now_s
            self._away_s.clear()
        if not may_drive or made != self._made:
            self._made, self._made_s = made, now_s
        stands = now_s - self._made_s > STALLS_S + late_s
        due_m = (now_s - self._turn_s - SLOW_S - late_s) * SLOW_SHARE * self._mission.speed_mps
        # Where obstacles move, it may have to wait for them.
        is_slow = mover.made_m < due_m and not self._mission.obstacles_move
        return self._culprit(turn, now_s) if stands or is_slow else None

    def _blind(self) -> int | None:
        """Rule 1."""
        heard = self._roster.heard
        return next((robot for robot in self._roster.start_order if heard[robot].leg_clear is None), None)

    def _culprit(self, turn: Turn, now_s: float) -> int:
        """Rule 2."""
        worst = max(self._away_s, key=lambda robot: self._away_s[robot], default=turn.robot)
        return worst if 2.0 * self._away_s[worst] > now_s - self._turn_s else turn.robot

    def _idler(self, now_s: float, patience_s: float, *, may_drive: bool) -> int | None:
        """Rule 3."""
        roster = self._roster
        strand = roster.strand
        if not may_drive or self._idle != (roster.turn, strand):
            self._idle, self._idle_s = (roster.turn, strand), now_s
        if not strand or now_s - self._idle_s <= patience_s:
            return None
        if len(strand) < len(roster.members):
            return strand[-1]
        return next((robot for robot in strand if roster.heard[robot].order != strand), strand[0])
