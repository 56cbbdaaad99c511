"""A fleet of real cores and its real world, as a system to explore.

Rule 1: by default every letter arrives at once, in the order in which letters were sent; then time passes
        until the world tells odometry. This is the schedule of a rehearsal without faults.
Rule 2: a fault strikes at the first letter in line, or when none is left. See `Kinds` for which there are.
Rule 3: faults strike while the window is open. Then the fleet goes on without more, until the end.
Rule 4: two moments that are equal as values go on in the same way. So message numbers come from the time at
        which they are sent: a message more or less at some time does not change all later ones.
Rule 5: contents of cores are compared when all letters have arrived, before time passes; that is where
        schedules meet. Until then cores are what they have heard (`clew.explore.trails`).
"""

from collections.abc import Iterable, Iterator, Sequence

from agents.events import TokensWatched
from agents.robot import Robot
from clew.explore.cores import Cores, Restart, RobotStep, Start, Thing, Tick, WorldStep
from clew.explore.explorable import Breach, Fault, Rank
from clew.explore.judge import judge_member, judge_order, judge_piece, judge_places, judge_plan
from clew.explore.moments import WORLD, Letter, Moment, Process
from clew.explore.setting import NEVER_TICKS, Kind, Setting
from protocol.fence import Fence, May
from protocol.keys import robot_name
from protocol.process.tokens import TokenCame, TokenWent
from protocol.timeline import StepPlanned, StrandFormed
from protocol.wire.messages import Drive, Odometry, Phase, Scan
from world.bodies.arena import TICK_S
from world.core import World

NUMBERS_PER_TICK = 4096  # of the messages of one process
LEASE_TICKS = 50  # 1 s: by then the router has dropped the token of a process that is cut off
FORGETS_FROM = 100_000  # cores and steps: some 500 MB
LIVES = 1000  # a robot's lives are apart from those of any other


class Fleet:
    """Three robots, say, in one setting."""

    def __init__(self, setting: Setting) -> None:
        self.setting = setting
        self._scenario = scenario = setting.scenario()
        self._mission = mission = scenario.mission()
        self._robots = range(1, scenario.fleet.robots + 1)
        world = World(scenario, seed=1, wall_s=0.0)
        constants = (mission, scenario, scenario.ground, scenario.movers, world.arena.guard)
        self.cores = Cores(world, self._make, constants)
        self._tick, self._restart = self.cores.things.add(Tick()), self.cores.things.add(Restart())
        self._first = self._passed(self._prefix(), setting.skips)
        self.window = self.rank(self._passed(self._first, setting.deliveries))
        """Faults strike at lower ranks."""
        self._ends_ticks = self.window[0] + setting.settle_ticks

    def _make(self, robot: int, life: int, again: bool) -> Robot:
        return Robot(robot, self._mission, life=life, again=again)

    # --- the beginning ------------------------------------------------------------------------------

    def _prefix(self) -> Moment:
        """The moment at which the window opens: what was to happen before has happened."""
        cores = self.cores
        count = len(self._robots)
        starts = tuple(
            Letter(WORLD, robot, 0, cores.things.add(Start(robot)), False) for robot in self._robots
        )
        moment = Moment(
            ticks=0,
            handled=0,
            world=cores.first_world,
            fence=cores.fences.add(Fence()),
            robots=(None,) * count,
            lives=(0,) * count,
            cut=(0,) * count,
            now=starts,
            later=(),
        )
        script = list(self.setting.before)
        while moment.ticks < self.setting.opens_ticks:
            if script and moment.ticks >= script[0][0] and self._is_time_for(script[0][1], moment):
                moment = self.strike(moment, script.pop(0)[1])
            else:
                moment = self._step(moment)
        assert not script, "the window opens before all has happened"
        return moment

    def _is_time_for(self, fault: Fault, moment: Moment) -> bool:
        """Whether a fault that comes before the window can strike now."""
        if fault.kind != Kind.LATE:
            return not moment.now
        letter = moment.now[0] if moment.now else None
        thing = None if letter is None or letter.sender != fault.robot else self.cores.things[letter.thing]
        return isinstance(thing, Drive) and thing.target is not None

    def _passed(self, moment: Moment, letters: int) -> Moment:
        """The moment after so many letters of those that faults may strike, without faults."""
        while letters > 0:
            letters -= bool(moment.now) and moment.now[0].is_fault_prone
            moment = self._step(moment)
        return moment

    # --- the system -------------------------------------------------------------------------------------

    def start(self) -> Moment:
        """The moment at which the window opens."""
        return self._first

    def rank(self, state: Moment) -> Rank:
        """Time, and how much has happened in this tick."""
        return state.ticks, state.handled

    def follow(self, state: Moment) -> Moment | None:
        """The first letter in line arrives, or time passes."""
        return None if state.ticks >= self._ends_ticks else self._step(state)

    def is_open(self, state: Moment) -> bool:
        """Rule 3."""
        return self.rank(state) < self.window

    def hurry(self, state: Moment) -> Moment | None:
        """All usual steps until time has passed: schedules hardly meet between."""
        after: Moment | None = state
        while after is not None and after.ticks == state.ticks:
            after = self.follow(after)
        return after

    def keep_only(self, states: Iterable[Moment]) -> None:
        """Forget what no schedule can come to any more, if it is much."""
        if len(self.cores) < FORGETS_FROM:
            return
        robots: set[int] = set()
        worlds: set[int] = set()
        for state in (self._first, *states):
            robots.update(process.core for process in state.robots if process is not None)
            worlds.add(state.world)
        self.cores.keep_only(robots, worlds)

    def faults(self, state: Moment) -> Iterator[Fault]:
        """Rule 2."""
        kinds, delays = self.setting.kinds, self.setting.delays_ticks
        if not state.now:
            yield from self._faults_of_processes(state)
            return
        letter = state.now[0]
        to = letter.receiver
        if not letter.is_fault_prone or self._is_lost(state, letter):
            return
        if Kind.LOSE in kinds:
            yield Fault(Kind.LOSE)
        if Kind.LATE in kinds:
            if any(other.receiver == to for other in state.now[1:]):
                yield Fault(Kind.LATE)
            yield from (Fault(Kind.LATE, 0, ticks) for ticks in delays)
        if Kind.TWICE in kinds:
            yield from (Fault(Kind.TWICE, 0, ticks) for ticks in delays)
        if Kind.KILL in kinds and to != WORLD:
            yield from (Fault(Kind.KILL, to, ticks) for ticks in self.setting.restarts_ticks)

    def _faults_of_processes(self, state: Moment) -> Iterator[Fault]:
        if Kind.CUT in self.setting.kinds:
            for robot in self._robots:
                if state.robots[robot - 1] is not None and state.cut[robot - 1] <= state.ticks:
                    yield from (Fault(Kind.CUT, robot, ticks) for ticks in self.setting.cuts_ticks)
        if Kind.WORLD in self.setting.kinds:
            yield Fault(Kind.WORLD)

    def strike(self, state: Moment, fault: Fault) -> Moment:
        """The moment after a fault."""
        after = state._replace(handled=state.handled + 1)
        rest = after._replace(now=state.now[1:])
        match Kind(fault.kind):
            case Kind.LOSE:
                after = rest
            case Kind.LATE if fault.ticks == 0:
                after = after._replace(now=(*state.now[1:], state.now[0]))
            case Kind.LATE:
                after = _later(rest, fault.ticks, state.now[0])
            case Kind.TWICE:
                after = _later(self._step(state), fault.ticks, state.now[0])
            case Kind.KILL:
                after = self._kill(after, fault.robot, fault.ticks)
            case Kind.CUT:
                after = self._cut(after, fault.robot, fault.ticks)
            case Kind.WORLD:
                after = self._restart_world(after)
        return self._settled(after)

    def say(self, state: Moment) -> str:
        """The letter that arrives, and what comes of it; or that time passes."""
        t_s = state.ticks * TICK_S
        if not state.now:
            return f"{t_s:.2f} s: time passes"
        letter = state.now[0]
        thing = self.cores.things[letter.thing]
        lost = " (lost)" if self._is_lost(state, letter) else ""
        return f"{t_s:.2f} s: {_name(letter.sender)} -> {_name(letter.receiver)}: {thing}{lost}"

    # --- steps --------------------------------------------------------------------------------------

    def _step(self, state: Moment) -> Moment:
        return self._settled(self._next(state))

    def _settled(self, state: Moment) -> Moment:
        """Rule 5."""
        if state.now:
            return state
        robots = tuple(
            process and process._replace(core=self.cores.settle_robot(process.core))
            for process in state.robots
        )
        return state._replace(robots=robots, world=self.cores.settle_world(state.world))

    def _next(self, state: Moment) -> Moment:
        if not state.now:
            return self._after_world(state, self.cores.world_step(state.world, self._tick, WORLD))
        letter, rest = state.now[0], state._replace(handled=state.handled + 1, now=state.now[1:])
        if isinstance(thing := self.cores.things[letter.thing], Start):
            return self._begin(rest, letter.receiver)
        if self._is_lost(state, letter):
            return rest
        if letter.receiver == WORLD:
            return self._after_world(rest, self.cores.world_step(state.world, letter.thing, letter.sender))
        return self._tell_robot(rest, letter, thing)

    def _is_lost(self, state: Moment, letter: Letter) -> bool:
        """Whether the receiver is down, or one of both is cut off."""
        if letter.receiver != WORLD and state.robots[letter.receiver - 1] is None:
            return not isinstance(self.cores.things[letter.thing], Start)
        cut = [
            state.cut[each - 1] > state.ticks for each in (letter.sender, letter.receiver) if each != WORLD
        ]
        return letter.is_fault_prone and any(cut)

    def _after_world(self, state: Moment, step: WorldStep) -> Moment:
        passed = step.ticks > state.ticks
        if step.places is not None:
            state = self._fence_changed(state, step)
        for robot, order in step.ordered:
            fence = self.cores.fences[step.fence]
            if fence.may is May.ALL:
                judge_member(robot, order, self._formed(state))
        sent = tuple(
            Letter(WORLD, robot, (step.ticks * NUMBERS_PER_TICK) + state.handled, thing)
            for robot, thing in step.sent
        )
        due = tuple(letter for tick, letter in state.later if tick <= step.ticks)
        return state._replace(
            ticks=step.ticks,
            handled=0 if passed else state.handled,
            world=step.world,
            fence=step.fence,
            now=(*state.now, *due, *sent),
            later=state.later[len(due) :],
        )

    def _fence_changed(self, state: Moment, step: WorldStep) -> Moment:
        assert step.places is not None
        before, after = self.cores.fences[state.fence], self.cores.fences[step.fence]
        if after.may is May.ALL:
            judge_places(after, self._formed(state), step.places, self._mission.mu0_m)
        return state if before.epoch == after.epoch else state._replace(formed=-1)

    def _formed(self, state: Moment) -> StrandFormed | None:
        formed: StrandFormed | None = None if state.formed < 0 else self.cores.things[state.formed]
        return formed

    def _tell_robot(self, state: Moment, letter: Letter, thing: Thing) -> Moment:
        robot = letter.receiver
        process = state.robots[robot - 1]
        assert process is not None, "what arrives at a process that is down is lost"
        if isinstance(thing, Odometry):
            if thing.t_s < process.now_s or thing.phase is not Phase.RUNNING:
                return state  # its shell drops older odometry
            process = self._told(process, thing, state.ticks)
        if isinstance(thing, Scan):
            process = process._replace(seen=letter.thing)
        step = self.cores.robot_step(process.core, letter, process.now_s)
        told = None if process.told < 0 else self.cores.fences[process.told]
        for order in step.orders:
            judge_order(robot, process.life, order, told)
        for note in step.notes:
            if isinstance(note, StepPlanned):
                judge_plan(robot, None if process.seen < 0 else self.cores.things[process.seen], told)
        state = self._with_formation(state, step)
        first = process.numbered
        sent = [
            Letter(robot, receiver, number, content)
            for number, (receiver, content) in enumerate(step.sent, start=first)
        ]
        process = process._replace(core=step.core, numbered=first + len(sent))
        return state._replace(robots=_put(state.robots, robot, process), now=(*state.now, *sent))

    def _told(self, process: Process, odometry: Odometry, ticks: int) -> Process:
        """The robot's newest odometry, by fence and number; and rule 4."""
        numbered = max(process.numbered, (ticks - process.began) * NUMBERS_PER_TICK)
        process = process._replace(now_s=odometry.t_s, numbered=numbered)
        known = None if process.told < 0 else self.cores.fences[process.told]
        if known is not None and (odometry.fence.key, odometry.n) < (known.key, process.told_n):
            return process
        return process._replace(told=self.cores.fences.add(odometry.fence), told_n=odometry.n)

    def _with_formation(self, state: Moment, step: RobotStep) -> Moment:
        """F4; what is told of an epoch that is not in force can move nobody."""
        epoch = self.cores.fences[state.fence].epoch
        for note in step.notes:
            if isinstance(note, StrandFormed) and note.epoch == epoch.number:
                if state.formed >= 0:
                    raise Breach("F4", f"a second formation in epoch {epoch.number}")
                state = state._replace(formed=self.cores.things.add(note))
        for member, piece in step.pieces:
            if piece.epoch == epoch:
                judge_piece(piece, member, self._formed(state))
        return state

    # --- processes ----------------------------------------------------------------------------------

    def _begin(self, state: Moment, robot: int) -> Moment:
        """A robot's process starts; it and all others see each other's tokens."""
        count = state.lives[robot - 1] + 1
        life = LIVES * robot + count
        core = self.cores.begin(robot, life, again=count > 1)
        state = state._replace(
            robots=_put(state.robots, robot, Process(core, life, state.ticks)),
            lives=_put(state.lives, robot, count),
        )
        others = [(other, state.lives[other - 1]) for other in self._living(state) if other != robot]
        seen = [(robot, TokenCame(other, str(life))) for other, life in [(WORLD, 1), *others]]
        shown: list[tuple[int, Thing]] = [(other, TokenCame(robot, str(count))) for other, _ in others]
        listed = (robot, TokensWatched(None))  # it has seen all that are shown, and watches them
        return self._with_tokens(state, [(WORLD, TokenCame(robot, str(count))), *shown, *seen, listed])

    def _kill(self, state: Moment, robot: int, back_ticks: int) -> Moment:
        """A robot's process dies, before it hears the letter in line; it is started again later, or never."""
        count = str(state.lives[robot - 1])
        shown = TokenCame(robot, count)  # after a cut, if it had lived until then
        later = tuple(each for each in state.later if self.cores.things[each[1].thing] != shown)
        state = state._replace(robots=_put(state.robots, robot, None), later=later)
        missed = [(other, TokenWent(robot, count)) for other in self._living(state)]
        state = self._with_tokens(state, [(WORLD, TokenWent(robot, count)), *missed])
        if back_ticks == NEVER_TICKS:
            return state
        start = Letter(WORLD, robot, 0, self.cores.things.add(Start(robot)), False)
        return _later(state, back_ticks, start)

    def _cut(self, state: Moment, robot: int, ticks: int) -> Moment:
        """A robot is cut off from all others and the world. After a second it and they see that."""
        state = state._replace(cut=_put(state.cut, robot, state.ticks + ticks))
        if ticks <= LEASE_TICKS:
            return state
        lives = state.lives
        others = [other for other in self._living(state) if other != robot]
        for after_ticks, token_of in ((LEASE_TICKS, TokenWent), (ticks, TokenCame)):
            own = token_of(robot, str(lives[robot - 1]))
            tokens: list[tuple[int, Thing]] = [(observer, own) for observer in (WORLD, *others)]
            tokens += [(robot, token_of(other, str(lives[other - 1]))) for other in others]
            tokens += [(robot, token_of(WORLD, "1"))]
            for receiver, token in tokens:
                letter = Letter(WORLD, receiver, 0, self.cores.things.add(token), False)
                state = _later(state, after_ticks, letter)
        return state

    def _restart_world(self, state: Moment) -> Moment:
        """The world is killed and started again at once; what was on its way to it is lost."""
        state = state._replace(now=tuple(letter for letter in state.now if letter.receiver != WORLD))
        state = self._after_world(state, self.cores.world_step(state.world, self._restart, WORLD))
        tokens = [(WORLD, TokenCame(robot, str(state.lives[robot - 1]))) for robot in self._living(state)]
        return self._with_tokens(state, tokens)

    def _living(self, state: Moment) -> list[int]:
        return [robot for robot in self._robots if state.robots[robot - 1] is not None]

    def _with_tokens(self, state: Moment, tokens: Sequence[tuple[int, Thing]]) -> Moment:
        letters = [Letter(WORLD, to, 0, self.cores.things.add(token), False) for to, token in tokens]
        return state._replace(now=(*state.now, *letters))


def _put(values: tuple[Thing, ...], robot: int, value: Thing) -> tuple[Thing, ...]:
    return (*values[: robot - 1], value, *values[robot:])


def _later(state: Moment, ticks: int, letter: Letter) -> Moment:
    """A letter arrives so many ticks from now, after all that arrive by then."""
    due = state.ticks + ticks
    place = sum(each <= due for each, _ in state.later)
    return state._replace(later=(*state.later[:place], (due, letter), *state.later[place:]))


def _name(process: int) -> str:
    return robot_name(process) if process else "world"
