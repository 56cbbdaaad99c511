"""When a robot calls all who live to line up again, and whom; docs/strand.md, Healing. Pure.

Rule 1: members are all robots that show a token. Who has not answered for long, or is not heard by others,
        is left out where the rest are more than half of those. Who misses much itself waits for longer. Who
        asks to be called, though it knows of this call, cannot answer it any more: it is called again.
Rule 2: who hears nobody does not call: nobody could answer, and it would only disturb.
Rule 3: a leader calls for the same robot again after twice the time, but not after more than `INVITES_S_MAX`.
Rule 4: a robot with which a link falls silent twice in a while, though both are there, is not heard for some
        time, twice as long each time; but it is where no way is found without it: its body may be in the way.
Rule 5: a robot that is left out stands so long after all members were bound, as far as this robot remembers;
        the latest time that any member remembers counts (`agents.membership.lining`). A clock that is told by
        odometry may lag, by as much as odometry is late: so it is asked for one that knows of an order given
        then.
Rule 6: members that leave others out go on only as long as these show no token, or they are more than half of
        those that do: tokens come back.
"""

from collections import Counter
from collections.abc import Sequence, Set
from itertools import chain

from agents.body.driver import Driver
from agents.membership.lining import Lining
from agents.membership.presence import GRACE_S, Presence
from agents.strand.strand import COMES_BACK_S
from protocol.epochs import called_epoch
from protocol.keys import WORLD_NUMBER
from protocol.mission import Mission

LISTENS_S = 1.5  # who has slept listens so long before it acts on a silence: a beacon comes every second
SLEPT_S = 0.8  # without an odometry: eight of them
ASIDE_S = 3.0  # three beacons
ANSWERS = 2.0  # times `patience_s` for a member to answer: where a link has three tries, a muster has six
GAPS = 2.0  # times as long as others were not heard, and then were
RANK_S = 0.3  # so much later than the robot before it a robot calls where several may: a round trip and more
INVITES_S = 2.0  # before the same robot is called in for the second time
INVITES_S_MAX = 30.0  # half of what a strand may take to heal: what made it fail may be over
FAILED_TURNS = 1  # so much more often it is doubled for who is left out though it is there
SHUNNED_S = 30.0  # half of what a strand may take to heal
BREAKS_MAX = 2
BREAKS_S = 60.0  # in which: a strand may take so long to heal
ASKS_S = 2.0  # two pleas


class Calls:
    """What one robot knows that decides on calls."""

    def __init__(self, robot: int, mission: Mission) -> None:
        self._robot = robot
        self._mission = mission
        self.presence = Presence()
        self.newest = 0
        """The newest epoch that it has heard of."""
        self.beacon_at_s = 0.0
        """When it last heard of a strand, or of a muster, that it is not in."""
        self._heard_at_s = -float("inf")
        self._entered_s = self._awake_since_s = 0.0
        self._invited: Counter[int] = Counter()
        self._invites_at_s: dict[int, float] = {}
        self._broke: dict[int, list[float]] = {}
        self._shuns: Counter[int] = Counter()
        self._shunned_until_s: dict[int, float] = {}
        self._pleaded: dict[int, tuple[int, float]] = {}
        """Who has asked to be called: the newest epoch that it had heard of, and when."""
        self._left_out_before: frozenset[int] = frozenset()
        self._settled_at_s = 0.0
        self._asked: tuple[Sequence[int], int] | None = None
        self._unlawful_at_s: float | None = None

    @property
    def _answer_s(self) -> float:
        """How long a member may take to answer."""
        return ANSWERS * self._mission.patience_s

    def _hearing_s(self, lining: Lining, robot: int) -> float:
        """How long it may take to hear a member: longer, to a limit, where this robot misses others."""
        return max(self._answer_s, min(GAPS * lining.gap_s(beside=robot), GAPS * self._answer_s))

    def enter(self, now_s: float) -> None:
        """The robot is entered: it may have slept."""
        if now_s - self._entered_s > SLEPT_S:
            self._awake_since_s = now_s
        self._entered_s = now_s

    def hear(self, epoch: int, now_s: float) -> None:
        """Something of an epoch has been heard from another robot."""
        self.newest, self._heard_at_s = max(self.newest, epoch), now_s

    def pleads(self, robot: int, epoch: int, now_s: float) -> None:
        """A robot that has heard of an epoch, and is not in it, asks to be called."""
        self._pleaded[robot] = (epoch, now_s)

    def broke(self, neighbour: int, now_s: float, *, since_s: float) -> None:
        """Rule 4: a link has been given up that was silent since then. Who was cut off may be heard again."""
        if not all(self.presence.has_shown_since(each, since_s) for each in (WORLD_NUMBER, neighbour)):
            return
        broke_s = self._broke.setdefault(neighbour, [])
        broke_s.append(now_s)
        lately = sum(now_s - at_s < BREAKS_S for at_s in broke_s)
        if lately >= BREAKS_MAX and neighbour not in self.shunned(now_s):
            self._shuns[neighbour] += 1
            self._shunned_until_s[neighbour] = now_s + SHUNNED_S * 2.0 ** (self._shuns[neighbour] - 1)

    def forgive(self, members: Sequence[int]) -> None:
        """Rule 4: no way is found without those who are not members: what they did does not count."""
        self._shunned_until_s = {
            robot: until_s for robot, until_s in self._shunned_until_s.items() if robot in members
        }
        self._broke = {robot: broke_s for robot, broke_s in self._broke.items() if robot in members}

    def shunned(self, now_s: float) -> frozenset[int]:
        """Rule 4."""
        return frozenset(robot for robot, until_s in self._shunned_until_s.items() if now_s < until_s)

    @property
    def is_awake(self) -> bool:
        """Whether it has listened for long enough to believe a silence."""
        return self._entered_s - self._awake_since_s >= LISTENS_S or self._awake_since_s == 0.0

    def is_heard(self, now_s: float) -> bool:
        """Rule 2."""
        alone = not self.presence.showing(now_s) - {self._robot}
        return self.presence.connected and (
            alone or now_s - self._heard_at_s <= 2.0 * self._mission.silence_s
        )

    def call(
        self, lining: Lining | None, now_s: float, *, among: tuple[int, ...] = ()
    ) -> tuple[int, tuple[int, ...]]:
        """Rule 1: the epoch and the members of a call, made now.

        Args:
            lining: one that has come to nothing, if this robot was in one.
            now_s: the time.
            among: who has answered, where no more than another order is asked for; empty: anybody.
        """
        shown = self.presence.showing(now_s) | {self._robot}
        answering = shown if lining is None else shown - self._left_out(lining, now_s)
        answering = answering & set(among) if among else answering
        members = answering if _may_leave_out(answering, shown) else shown
        return called_epoch(self.newest, self._robot, now_s), tuple(sorted(members))

    def may_go_on(self, members: Sequence[int], now_s: float) -> bool:
        """Rule 6: whether they may still leave the others out, by the tokens that there are now."""
        if self._asked != (members, self.presence.version):
            self._asked = (members, self.presence.version)
            shown = self.presence.robots | {self._robot}
            inside = shown & set(members)
            lawful = _may_leave_out(inside, shown)
            self._unlawful_at_s = None if lawful else self._unlawful_at_s or now_s
        at_s = self._unlawful_at_s
        return at_s is None or now_s - at_s < GRACE_S or not self.presence.connected

    def wants_another(self, lining: Lining, now_s: float) -> str | None:
        """Why a lining up will come to nothing; None where it may."""
        rank = sum(robot < self._robot for robot in lining.members)
        late_s = RANK_S * rank
        for robot in lining.members:
            heard_at_s = lining.heard_at_s(robot)
            if robot == self._robot:
                continue
            if self.presence.is_lost(robot, heard_at_s, now_s - late_s):
                return f"robot {robot} is lost"
            if now_s - heard_at_s > self._hearing_s(lining, robot) + late_s:
                return f"robot {robot} does not answer"
        stalled = lining.stalled(now_s, late_s=late_s)
        if stalled is not None and stalled != self._robot:
            return f"robot {stalled} keeps the others waiting"
        deaf_s = self._answer_s + late_s
        if lining.is_called and now_s - lining.began_s > deaf_s and lining.unheard_pairs():
            return "some members do not hear each other"
        return None

    def stand_aside(self, now_s: float) -> None:
        """This robot is in nothing: others may come and go without it, and it must wait for any of them."""
        self.beacon_at_s = now_s
        self._left_out_before = frozenset()

    def bind(self, members: tuple[int, ...]) -> None:
        """A muster is joined: whoever is called may drive again, and would have to be waited for again."""
        self._left_out_before -= set(members)

    def invites(self, robot: int, now_s: float) -> bool:
        """Rule 3: whether to call a robot in that asks for it; asked means done."""
        too_early = now_s < self._invites_at_s.get(robot, 0.0)
        if too_early or not self.presence.shows(robot) or robot in self.shunned(now_s):
            return False  # whom it does not hear it would call in vain
        self._next_invitation(robot, now_s)
        self._invited[robot] += 1
        return True

    def _next_invitation(self, robot: int, now_s: float) -> None:
        self._invites_at_s[robot] = now_s + min(INVITES_S * 2.0 ** self._invited[robot], INVITES_S_MAX)

    def attend(self, lining: Lining, driver: Driver, now_s: float) -> None:
        """Have a lining up know what tokens and clocks say of those that are left out."""
        went_by_s = now_s - COMES_BACK_S
        gone = [self.presence.has_gone_by(robot, went_by_s) for robot in self._outside(lining.members)]
        lining.others_may_come_back = not all(gone)
        if lining.settled_at_s is None and lining.all_are_bound:
            self._settle(lining, driver, now_s)

    def _settle(self, lining: Lining, driver: Driver, now_s: float) -> None:
        """Rule 5: have a lining up know when its members may drive, now that all are bound."""
        if self._newly_left_out(lining.members):
            if lining.asked is None:
                lining.asked = driver.stand_anew(epoch=lining.epoch)
            if driver.odometry.ordered < lining.asked:
                return
        lining.settled_at_s = self.free_at_s(lining.members, now_s)

    def _outside(self, members: tuple[int, ...]) -> frozenset[int]:
        """All robots but these."""
        return frozenset(range(1, self._mission.robots + 1)).difference(members)

    def _newly_left_out(self, members: tuple[int, ...]) -> frozenset[int]:
        return self._outside(members) - self._left_out_before

    def free_at_s(self, members: tuple[int, ...], now_s: float) -> float:
        """When whoever is left out stands for good, at a time since when all members are bound.

        Of a row that is cut off each comes to stand when the one beside it has left the strand.
        """
        mission = self._mission
        newly = self._newly_left_out(members)
        self._left_out_before = self._outside(members)
        for robot in newly & self.presence.robots:  # rule 3, for one that is there and did not do
            self._invited[robot] += FAILED_TURNS
            self._next_invitation(robot, now_s)
        if newly:
            stands_s = mission.silence_s + mission.deadman_s
            row_s = (len(newly) - 1) * (mission.silence_s + mission.patience_s)
            self._settled_at_s = max(self._settled_at_s, now_s + row_s + stands_s)
        return max(now_s, self._settled_at_s)

    def _left_out(self, lining: Lining, now_s: float) -> set[int]:
        """Rule 1: who has not answered; then whoever is part of most pairs that do not hear each other."""
        out = {
            robot
            for robot in lining.members
            if robot != self._robot and now_s - lining.heard_at_s(robot) > self._hearing_s(lining, robot)
        }
        stalled = lining.stalled(now_s)
        out |= set() if stalled is None else {stalled}
        deaf = lining.is_called and now_s - lining.began_s > self._answer_s
        pairs = lining.unheard_pairs() if deaf else set()
        while pairs := {pair for pair in pairs if not out.intersection(pair)}:
            worst, unheard = Counter(chain.from_iterable(pairs)), Counter(other for _, other in pairs)
            # Of two that are as bad, the one that has not done before; else the one that is not heard: the
            # other may shun it for a reason; else the one that this robot has missed for longer.
            guilt = {
                robot: (pairs_of, self._invited[robot], unheard[robot], lining.missed_s(robot, now_s), robot)
                for robot, pairs_of in worst.items()
            }
            out.add(max(guilt, key=lambda robot: guilt[robot]))
        return {robot for robot in out if not self._asks(robot, lining, now_s)}

    def _asks(self, robot: int, lining: Lining, now_s: float) -> bool:
        """Rule 1: whether it knows of the call that it has not answered, and may be called again."""
        epoch, at_s = self._pleaded.get(robot, (0, -float("inf")))
        return epoch >= lining.epoch and now_s - at_s <= ASKS_S and self.invites(robot, now_s)


def _may_leave_out(members: Set[int], shown: Set[int]) -> bool:
    """Rule 1: whether they are more than half of those that show a token."""
    return 2 * len(members) > len(shown)
