"""`clew judge`: judges a run a second time, from true poses and the scene alone."""

from pathlib import Path
from typing import TYPE_CHECKING

import click

from clew.verbs.options import AS_JSON, PATH
from clew.verbs.say import say, say_json, warn
from protocol.errors import UsageError

if TYPE_CHECKING:
    from clew.verbs.judged import Judged


@click.command("judge")
@click.argument("run", type=PATH)
@click.argument("scene", required=False, type=PATH)
@AS_JSON
@click.pass_context
def judge_verb(ctx: click.Context, run: Path, scene: Path | None, *, as_json: bool) -> None:
    """Judge a run a second time, from true poses and the scene alone.

    RUN is the folder of a run, or its events.jsonl. SCENE is a scenario (a name or a file) or a scene, to use
    instead of the scenario in the run's header; stderr says how the two differ. This judge shares no code
    with the world's and uses no entry of a robot. It prints the least distances with their times, and where
    each robot stands at the end.
    The folder of a run with several fleets has one for each: all are judged, and the distances between them.

    Exits with 1 when a promise was broken, the fleet did not arrive, or verdict.json says otherwise.
    """
    from clew.log.log import fleets_in

    fleets = fleets_in(run)
    if fleets and scene is not None:
        raise UsageError("SCENE: is for a run with one fleet; judge the folder of one fleet with it")
    try:
        ok = _judge_all(run, fleets, as_json=as_json) if fleets else _judge_one(run, scene, as_json=as_json)
    except OSError as error:
        if error.filename is None:  # it is of stdout
            raise
        raise UsageError(f"{error.filename}: cannot be read: {error.strerror}") from error
    ctx.exit(0 if ok else 1)


def _judge_one(run: Path, scene: Path | None, *, as_json: bool) -> bool:
    from clew.log.flaws import STILL_GOING_ON
    from clew.verbs.judged import judged
    from protocol.faults.manual_faults import is_running

    if is_running(run if run.is_dir() else run.parent):
        warn(f"{run}: {STILL_GOING_ON}")
    one = judged(run, scene)
    if one.truth.otherwise:
        differs = ", ".join(one.truth.otherwise)
        warn(f"{scene}: is not the scenario of this run: other {differs}; the judgement is by {scene}")
    if as_json:
        say_json(one.said())
    else:
        _print(one)
    return one.ok


def _judge_all(run: Path, fleets: list[str], *, as_json: bool) -> bool:
    """Judge a run with several fleets."""
    from clew.verbs.judged import judged, judged_between

    each = {name: judged(run / name, None) for name in fleets}
    near, wrong = judged_between(run, each)
    contacts = [str(least) for least in near if least.distance_m <= 0.0]
    ok = not contacts and not wrong and all(one.ok for one in each.values())
    if as_json:
        said = {name: one.said() for name, one in each.items()}
        nearest = near[0] if near else None
        say_json({"ok": ok, "fleets": said, "nearest": nearest, "contacts": contacts, "disagreements": wrong})
        return ok
    for name, one in each.items():
        say(f"fleet {name}:")
        _print(one)
    say(f"nearest between fleets: {near[0] if near else 'none'}")
    for contact in contacts:
        say(f"contact: {contact}")
    _print_differences(wrong)
    say(f"{'OK' if ok else 'FAILED'}: {len(each)} fleets, {len(contacts)} contacts between them")
    return ok


def _print(one: "Judged") -> None:
    finding = one.finding
    for name in ("clearance", "moving_clearance", "separation"):
        say(f"least {name.replace('_', ' ')}: {getattr(finding, name) or 'none'}")
    for robot, (x_m, y_m) in finding.places_m.items():
        rank = f"{finding.chain.index(robot) + 1} in the chain" if robot in finding.chain else "in no chain"
        say(f"robot {robot} stands at ({x_m:.4f}, {y_m:.4f}), {rank}")
    if finding.goal_m is not None:
        say(f"nearest to the goal: {finding.goal_m:.4f} m")
    for each in (*finding.broken, *finding.missed):
        say(each)
    _print_differences(one.wrong)
    agreed = (
        "there is no verdict" if one.wrong is None else f"the verdict {'differs' if one.wrong else 'agrees'}"
    )
    kept = "broken" if finding.broken else "kept"
    arrived = "not arrived" if finding.missed else "arrived"
    say(f"{'OK' if one.ok else 'FAILED'}: promises {kept}, {arrived}; {agreed}")


def _print_differences(wrong: list[str] | None) -> None:
    for each in wrong or ():
        say(f"the verdict differs: {each}")
