"""Rehearses several fleets on one ground: each a whole rehearsal of its own, all in one clock.

Rule 1: the fleets share the ground and the clock, and nothing else: no key, no message, no fence, no seed.
Rule 2: in each tick all fleets sense the bodies of one instant; then all move.
Rule 3: a fleet whose run has ended stands where it is, and the others go on.
Rule 4: the run's folder has a folder for each fleet, which is that of a run; and `verdict.json` on all.
"""

from collections.abc import Callable, Iterator
from contextlib import ExitStack
from pathlib import Path

from clew.rehearsal.endless_law import asked_to_end_in_laws
from clew.rehearsal.recorded import KEPT_BYTES, Recorded
from clew.rehearsal.rehearsal import Asked, nobody_asks
from protocol.arrays import Floats
from protocol.faults.plan import NO_FAULTS, Plan
from protocol.files.writing import make_folder
from protocol.run_settings import Settings
from world.judge.hulls import AllHulls
from world.judge.together import TogetherVerdict, pass_together
from world.judge.verdict import Verdict
from world.record.run_files import prepare_together, save_verdict
from world.scenario.fleets import SharedGround, seed_of


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
        self.hulls = AllHulls(scenarios)
        self.fleets: dict[str, Recorded] = {}
        """The rehearsal of each fleet, by name."""
        self._open = ExitStack()
        with ExitStack() as opening:
            prepare_together(folder, shared, Settings(seed=seed))
            for name, scenario in scenarios.items():
                make_folder(folder / name)
                say_of = self._sayer(name)
                recorded = opening.enter_context(
                    Recorded(
                        scenario, seed_of(seed, name), folder / name, plan, say_of, keeps_bytes=KEPT_BYTES
                    )
                )
                recorded.rehearsal.world.arena.share_ground(self.hulls.others_of(name))
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
            for contact in self.hulls.move(self._places_m(), t_s=now_s):
                self._say(f"contact: {contact}")
            yield now_s

    def _places_m(self) -> dict[str, Floats]:
        return {name: each.rehearsal.world.bodies.place_m for name, each in self.fleets.items()}

    def judge(self) -> TogetherVerdict:
        """Write the verdicts on all rehearsals, which have ended."""
        verdicts: dict[str, Verdict] = {name: each.judge() for name, each in self.fleets.items()}
        verdict = pass_together(self._shared.name, self._seed, verdicts, self.hulls.between)
        save_verdict(verdict, self._folder)
        return verdict


def rehearse_fleets(
    shared: SharedGround, seed: int, folder: Path, say: Callable[[str], None], plan: Plan = NO_FAULTS
) -> TogetherVerdict:
    """Rehearse all fleets of a scenario into an existing folder; `say` gets the lines of progress.

    Raises:
        UsageError, RecordingFailedError: as `Recorded`.
    """
    with asked_to_end_in_laws() as asked, RecordedFleets(shared, seed, folder, plan, say) as recorded:
        for _ in recorded.ticks(lambda: asked[-1] if asked else None):
            pass
        return recorded.judge()
