"""A robot's part in the strand of one formation: it leads, backs up or follows, by its rank.

Rule 1 (safety, F4 and F5 of docs/strand.md): a robot gives orders and tells link states only under the
        formation's ALL, and only if it stood at its place in the formation; else it wants a new one.
Rule 2 (safety): where obstacles move, a robot looks while it drives (`agents.body.watch`).
Rule 3 (liveness): the stretch rule. A robot waits while the robot behind, as last heard, is too far behind
        what it has been granted. A robot that backs up does not wait for those that will not come further.
Rule 4 (liveness): a strand that turns round, dissolves, or whose leader knows no way has made an attempt in
        vain. After `IN_VAIN_MAX` of them without an advance, the leader records with the next one that the
        route is lost; it does so even if another robot has made that one. To back up is no further attempt.
"""

from msgspec.structs import replace

from agents.body.driver import Driver
from agents.body.senses import Senses
from agents.body.watch import Watch
from agents.commands import Command, Note
from agents.events import LinkHeard
from agents.liveness.reason import Reason
from agents.strand.advance import Advance, Following
from agents.strand.blocked import Blocked
from agents.strand.follower import Follower
from agents.strand.leading import SETTLED_S, Leading
from agents.strand.memory import Memory
from agents.strand.news import Own
from agents.strand.reversing import Reversing
from agents.strand.strand import Strand
from protocol.fence import Bearing, Cause
from protocol.frames import apart_m, one_more
from protocol.mission import Mission
from protocol.path import Path
from protocol.timeline import (
    LeaderSucceeded,
    RobotHeld,
    RobotReleased,
    StrandHealed,
    StrandJoined,
)
from protocol.wire.view import Counters, Formation

RELEASE_SHARE = 0.9  # of the link's length: so that a robot at the limit does not stop and go
GROWN_M_MIN = 0.1  # of the path, worth telling
IN_VAIN_MAX = 8  # since the strand last advanced: each attempt may undo what the one before has done
TOO_OFTEN = "the strand has turned round, dissolved or known no way too often"


class Member:
    """The decisions of one robot in the strand. They are valid only under the formation's ALL."""

    def __init__(
        self,
        robot: int,
        *,
        mission: Mission,
        driver: Driver,
        senses: Senses,
        memory: Memory,
        formation: Formation,
        path: Path,
        now_s: float,
    ) -> None:
        """Take a place in a strand, under the formation's fence; `path` is all of it, as told.

        `formation` is its first piece, which alone has the map. `memory` outlives a strand.
        """
        self._robot = robot
        self._mission = mission
        self._driver = driver
        self._formation = formation
        self._leads = formation.rank == 0
        self._memory = memory
        bearing = Bearing(epoch=formation.epoch, turn=formation.turn, life=formation.life)
        driver.begin(formation.s_m, bearing)
        memory.take(formation)
        self._strand = Strand(robot, formation, path, mission, now_s)
        left_out = formation.members < mission.robots
        follower = Follower(mission, formation.s_m, some_are_left_out=left_out)
        self._advance = Advance(mission, driver, senses, follower)
        self._watch = Watch(mission, driver, senses)
        self._blocked = Blocked(mission, self._strand, self._advance, self._watch)
        self._leading = Leading(mission, driver, senses, memory, self._strand)
        self._reversing = Reversing(driver, self._strand, self._advance, self._leading)
        self._following = Following(driver, self._strand, self._advance)
        self._joined = self._held = False
        off_m = apart_m(driver.odometry.pose, formation.place)
        self._misfit = off_m > mission.mu0_m
        self._reason = (
            Reason(Cause.MISFIT, f"robot {robot} stands {off_m:.3f} m off its place", about=robot)
            if self._misfit
            else None
        )

    # --- what it is -----------------------------------------------------------------------------------

    @property
    def formation(self) -> Formation:
        """The formation of which it is a member."""
        return self._formation

    @property
    def fits(self) -> bool:
        """Whether it stood at its place when it took it."""
        return not self._misfit

    @property
    def reason(self) -> Reason | None:
        """Why it wants a new view; None: it wants none."""
        return self._reason

    @property
    def strand(self) -> Strand:
        """Its links, its authority, and what it has granted."""
        return self._strand

    @property
    def path(self) -> Path:
        """The path, as far as this robot knows it and any robot has driven it or may."""
        return self._strand.growth.driven(self._driver.progress_m)

    @property
    def progress_m(self) -> float:
        """Where along the path it is now."""
        return min(self._driver.progress_m, self.path.end_m)

    @property
    def holds(self) -> bool:
        """Whether it waits for the robot behind (rule 3)."""
        return self._held

    @property
    def has_moved(self) -> bool:
        """Whether it may have left its place in the formation."""
        return self._driver.was_sent

    @property
    def leads(self) -> bool:
        """Whether it is the first of the strand."""
        return self._leads

    @property
    def arrived(self) -> bool:
        """Whether it has come to its place at the goal, behind the robots ahead."""
        return self._leading.arrived if self._leads else self._following.arrived

    @property
    def rests(self) -> bool:
        """Whether it has arrived, and the robots behind it, as last heard, have stood for a while."""
        return self.arrived and self._strand.quiet_s >= SETTLED_S

    @property
    def counters(self) -> Counters:
        """What the next formation has to count, with what this robot wants."""
        counters, reason = self._strand.counters, self._reason
        counters = replace(counters, steps=max(counters.steps, self._memory.steps))
        match None if reason is None else reason.cause:
            case Cause.NO_WAY:
                # Each robot once, whatever others have told: so the message has room for all.
                last = dict.fromkeys((*counters.last_to_lead, self._robot))
                in_vain = one_more(counters.in_vain)
                return replace(counters, in_vain=in_vain, last_to_lead=tuple(last))
            case Cause.DEAD_END if self._backs_up:
                return counters
            case Cause.DEAD_END | Cause.BLOCKED:
                return replace(counters, in_vain=one_more(counters.in_vain))
            case _:
                return counters

    def lets_lead(self, robot: int) -> bool:
        """Whether it leads, knows no way on, and a robot that is left out may lead before others."""
        is_last = robot in self._strand.counters.last_to_lead
        return self._leads and self._leading.knows_no_way and not is_last

    # --- what it does ---------------------------------------------------------------------------------

    def hear(self, heard: LinkHeard, now_s: float) -> list[Command]:
        """Take in a neighbour's state."""
        strand = self._strand
        commands = strand.watch(now_s) + strand.hear(heard, now_s) + strand.watch(now_s)
        if strand.ahead is not None and strand.ahead.state is not None and strand.ahead.state.handed:
            self._memory.succeed(strand.ahead.state.handed)
        return commands

    def act(self, now_s: float) -> list[Command]:
        """What is to be done now; under any fence but the formation's ALL, nothing (rule 1)."""
        if self._misfit or not self._driver.may_drive:
            return []
        commands = self._join() + self._strand.watch(now_s) + self._hold()
        if self._held:
            self._driver.stand()
        else:
            commands += self._move(now_s)
        commands += self._look(now_s)
        commands += self._decide(now_s)
        own = Own(self._driver.progress_m, self._driver.standing, self.arrived, self._memory.handover)
        return commands + self._strand.tell(own, now_s)

    def _join(self) -> list[Command]:
        """Note, when it first acts, what the formation is."""
        if self._joined:
            return []
        self._joined = True
        formation, number = self._formation, self._formation.epoch.number
        joined = StrandJoined(epoch=number, rank=formation.rank, members=formation.members)
        notes: list[Command] = [Note(joined)]
        if self.leads and formation.heals and formation.led_by not in (0, self._robot):
            notes.append(Note(LeaderSucceeded(epoch=number, before=formation.led_by)))
        if self.leads and formation.heals:
            notes.append(Note(StrandHealed(epoch=number, robots=formation.members)))
        return notes

    def _move(self, now_s: float) -> list[Command]:
        if not self._leads:
            return self._following.act(now_s)
        return self._reversing.act(now_s) if self._backs_up else self._leading.act(now_s)

    @property
    def _backs_up(self) -> bool:
        return self._leads and self._strand.back_by_m > 0.0

    def _look(self, now_s: float) -> list[Command]:
        """Rule 2: drive on as long as the newest scan is good; give up a step that stays without one."""
        driver, strand = self._driver, self._strand
        if driver.progress_m - strand.path.end_m >= GROWN_M_MIN:
            strand.growth.come_to(driver.progress_m)
        looks = self._watch.look(now_s)
        if self._leading.has_step and self._watch.gives_up(now_s):
            self._watch.begin_again()
            self._leading.give_up_step()
            return []
        return looks

    def _hold(self) -> list[Command]:
        """Rule 3."""
        stretch_m = 0.0 if self._backs_up else self._strand.grants.stretch_m
        limit_m = self._mission.link_length_m_max * (RELEASE_SHARE if self._held else 1.0)
        if (stretch_m > limit_m) == self._held:
            return []
        self._held = not self._held
        return [Note(RobotHeld(behind_m=stretch_m) if self._held else RobotReleased())]

    def _decide(self, now_s: float) -> list[Command]:
        """Whether it wants a new view now (rule 4)."""
        self._reason = self._wanted(now_s)
        if not self._leads or self._backs_up or self.counters.in_vain <= IN_VAIN_MAX:
            return []
        self._reason = None
        return self._leading.lose(TOO_OFTEN)

    def _wanted(self, now_s: float) -> Reason | None:
        leader = self._reversing if self._backs_up else self._leading
        reason = leader.reason if self._leads else None
        is_blocked = reason is None and not self._held and self._blocked.is_so(now_s)
        return self._blocked.reason if is_blocked else reason
