"""`clew bench rehearsal`: times whole rehearsals. It is the shell: it reads the clocks."""

import time
from importlib.util import find_spec
from typing import TYPE_CHECKING

import click

from clew.verbs.bench_said import begin, print_figures
from clew.verbs.extras import install_line
from clew.verbs.options import AS_JSON, runs_option
from clew.verbs.say import warn
from protocol.faults.plan import NO_FAULTS, uniform
from protocol.faults.plan import load as load_plan
from protocol.frames import ROBOTS_MAX

if TYPE_CHECKING:
    from clew.bench.rehearsal import Peer
    from world.scenario.scenario import Scenario

LOSS = 0.3


@click.command()
@click.argument("scenario", default="grove")
@runs_option("How many rehearsals of each fault plan to time.", default=5)
@click.option(
    "--faults",
    "plans",
    multiple=True,
    help="Fault plan, a name or a file; repeatable. Default: no faults, 30 % loss, and the leader killed.",
)
@click.option(
    "--queue",
    "lengths",
    multiple=True,
    type=click.IntRange(1, ROBOTS_MAX),
    help="Also time a queue of so many robots that drives 3.5 m over open ground; repeatable.",
)
@AS_JSON
def rehearsal(
    scenario: str, runs: int, plans: tuple[str, ...], lengths: tuple[int, ...], *, as_json: bool
) -> None:
    """Time whole rehearsals: simulated seconds, and messages, per CPU second.

    For comparison, the same number of ticks and messages is timed with cores that do nothing; without
    faults, ir-sim with robots that drive straight on in the same scene (the extra `peers`); and, for
    queues of several lengths, what a robot costs in the shortest one.
    """
    from clew.bench.forming import queue
    from clew.bench.rehearsal import figures_of, growth, speed
    from world.scenario.scenario import load

    known = load(scenario)
    peer = _peer(known)
    asked = [load_plan(each) for each in plans] or [NO_FAULTS, uniform(loss=LOSS), load_plan("leader-killed")]
    title = f"Rehearsals of {known.name} with {known.fleet.robots} robots"
    about = f"{title}, and queues on open ground: simulated seconds per CPU second. A repeat is a rehearsal."
    begun = begin("rehearsal", about)
    rows = [
        speed(
            f"faults: {each.name}",
            known,
            each,
            runs=runs,
            cpu=time.process_time,
            peer=None if each.rules else peer,
        )
        for each in asked
    ]
    queues = [
        speed(f"queue of {robots}", queue(robots), NO_FAULTS, runs=runs, cpu=time.process_time)
        for robots in lengths
    ]
    found = [*(figure for row in (*rows, *queues) for figure in figures_of(row)), *growth(queues)]
    if as_json:
        packages = ("ir-sim",) if any(row.peer_s for row in rows) else ()
        begun.say_json(found, (*rows, *queues), packages)
    else:
        print_figures(title, found)


def _peer(scenario: "Scenario") -> "Peer | None":
    """The peer that is timed beside; None: there is none, and a line says why."""
    from clew.bench.peer import stepper

    if find_spec("irsim") is None:
        warn(f"ir-sim is not installed, so it is no baseline; to install it: {install_line('peers')}")
        return None
    if scenario.goal is None:
        warn(f"{scenario.name}: has no goal, so ir-sim is no baseline")
        return None
    return stepper
