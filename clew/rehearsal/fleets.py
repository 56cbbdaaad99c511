"""Rehearses several fleets on one ground: each a whole rehearsal of its own, all in one clock.

Rule 1: the fleets share the ground and the clock, and nothing else: no key, no message, no fence, no seed.
Rule 2: in each tick all fleets sense the bodies of one instant; then all move.
Rule 3: a fleet whose run has ended stands where it is, and the others go on.
Rule 4: the run's folder has a folder for each fleet, which is that of a run; and `verdict.json` on all.
"""

from collections.abc import Callable, Iterator, Mapping
from contextlib import ExitStack
from pathlib import Path

import msgspec
import numpy as np

from clew.rehearsal.recorded import Recorded
from clew.rehearsal.rehearsal import Asked, nobody_asks
from protocol.arrays import Floats
from protocol.asked import asked_to_end
from protocol.faults.plan import NO_FAULTS, Plan
from protocol.files.toml_text import toml_text
from protocol.files.writing import make_folder, write_whole
from protocol.run_settings import SCENARIO_FILE, SEED_MAX, Settings, texts
from world.chance import stream
from world.judge.between import Between, Encounter
from world.judge.together import TogetherVerdict, pass_together
from world.judge.verdict import VERDICT_FILE, Verdict
from world.scenario.fleets import SharedGround
from world.scenario.scenario import Scenario


def seed_of(seed: int, fleet: str) -> int:
    """The seed of one fleet: with one seed for all, robots of the same number would draw the same errors."""
    return int(stream(seed, f"fleet/{fleet}").integers(SEED_MAX))


class Ground:
    """Where the bodies of all fleets are: what each sees of the others, and the monitor between them."""

    def __init__(self, scenarios: Mapping[str, Scenario]) -> None:
        fleets = {name: each.fleet for name, each in scenarios.items()}
        self.between = Between({name: (each.robots, each.robot_radius_m) for name, each in fleets.items()})
        """What has come between the fleets."""
        self._hulls = {
            name: np.array([(pose.x_m, pose.y_m, each.robot_radius_m) for pose in each.poses()])
            for name, each in fleets.items()
        }

    def others_of(self, fleet: str) -> Callable[[], Floats]:
        """What shows the hulls of the other fleets, x, y, radius (k, 3) [world frame], at this instant."""
        return lambda: np.concatenate([hulls for name, hulls in self._hulls.items() if name != fleet])

    def move(self, places_m: Mapping[str, Floats], *, t_s: float) -> list[Encounter]:
        """Put all bodies to their places at the end of a tick; returns new contacts."""
        before_m = self._places_m()
        for name, hulls in self._hulls.items():
            self._hulls[name] = np.column_stack((places_m[name], hulls[:, 2]))
        return self.between.watch(before_m, self._places_m(), t_s=t_s)

    def _places_m(self) -> Floats:
        return np.concatenate([hulls[:, :2] for hulls in self._hulls.values()])


class RecordedFleets:
    """Rehearsals of several fleets that are written into an existing folder while they go on.

    Raises:
        UsageError, RecordingFailedError: as `Recorded`.
    """

    def __init__(
        self,
        shared: SharedGround,
        seed: int,
        folder: Path,
        plan: Plan = NO_FAULTS,
        say: Callable[[str], None] = lambda _: None,
    ) -> None:
        self._shared, self._seed, self._folder, self._say = shared, seed, folder, say
        scenarios = shared.scenarios()
        self.ground = Ground(scenarios)
        self.fleets: dict[str, Recorded] = {}
        """The rehearsal of each fleet, by name."""
        self._open = ExitStack()
        with ExitStack() as opening:
            _write_request(folder, shared, seed)
            for name, scenario in scenarios.items():
                make_folder(folder / name)
                recorded = opening.enter_context(
                    Recorded(scenario, seed_of(seed, name), folder / name, plan, self._sayer(name))
                )
                recorded.rehearsal.world.arena.share_ground(self.ground.others_of(name))
                self.fleets[name] = recorded
            self._open = opening.pop_all()

    def _sayer(self, fleet: str) -> Callable[[str], None]:
        return lambda said: self._say(f"{fleet}: {said}")

    def __enter__(self) -> "RecordedFleets":
        return self

    def __exit__(self, *_: object) -> None:
        self._open.close()

    def ticks(self, asked: Asked = nobody_asks) -> Iterator[float]:
        """Run tick by tick until every run has been judged; yields the time after each tick."""
        going = {name: each.ticks(asked) for name, each in self.fleets.items()}
        now_s = 0.0
        while going:
            times = {name: next(ticks, None) for name, ticks in going.items()}
            going = {name: ticks for name, ticks in going.items() if times[name] is not None}
            now_s = max([now_s, *(t_s for t_s in times.values() if t_s is not None)])
            for contact in self.ground.move(self._places_m(), t_s=now_s):
                self._say(f"contact: {contact}")
            yield now_s

    def _places_m(self) -> dict[str, Floats]:
        return {name: each.rehearsal.world.bodies.place_m for name, each in self.fleets.items()}

    def judge(self) -> TogetherVerdict:
        """Write the verdicts on all rehearsals, which have ended."""
        verdicts: dict[str, Verdict] = {name: each.judge() for name, each in self.fleets.items()}
        between = self.ground.between
        assert between.least is not None, "at least one tick has been judged"
        verdict = pass_together(
            self._shared.name,
            self._seed,
            verdicts,
            nearest=between.least,
            contacts=between.contacts,
        )
        text = msgspec.json.format(msgspec.json.encode(verdict)) + b"\n"
        write_whole(self._folder / VERDICT_FILE, text)
        return verdict


def rehearse_fleets(
    shared: SharedGround, seed: int, folder: Path, say: Callable[[str], None], plan: Plan = NO_FAULTS
) -> TogetherVerdict:
    """Rehearse all fleets of a scenario into an existing folder; `say` gets the lines of progress.

    Raises:
        UsageError, RecordingFailedError: as `Recorded`.
    """
    with asked_to_end() as asked, RecordedFleets(shared, seed, folder, plan, say) as recorded:
        for _ in recorded.ticks(lambda: asked[-1] if asked else None):
            pass
        return recorded.judge()


def _write_request(folder: Path, shared: SharedGround, seed: int) -> None:
    """The resolved request, before anything starts; the folders of the fleets have theirs."""
    said = {SCENARIO_FILE: toml_text(msgspec.to_builtins(shared)), **texts(Settings(seed=seed), NO_FAULTS)}
    for name, text in said.items():
        write_whole(folder / name, text.encode())
