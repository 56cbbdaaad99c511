"""`clew judge`: judges a run a second time, by true poses and the scene alone."""

import dataclasses
from pathlib import Path
from typing import TYPE_CHECKING

import click

from clew.verbs.options import AS_JSON
from clew.verbs.say import say, say_json
from protocol.errors import UsageError

if TYPE_CHECKING:
    from clew.judge.poses import Finding


@click.command("judge")
@click.argument("run", type=click.Path(path_type=Path))
@click.argument("scene", required=False, type=click.Path(path_type=Path))
@AS_JSON
@click.pass_context
def judge_verb(ctx: click.Context, run: Path, scene: Path | None, *, as_json: bool) -> None:
    """Judge a run a second time, by true poses and the scene alone.

    RUN is the folder of a run, or its events.jsonl; SCENE a scenario or a scene, instead of the scenario in
    the run's header. This judge shares no code with the world's and uses no entry of a robot. It prints the
    least distances with their times, and where each robot stands at the end. The folder of a run with several
    fleets has one for each: all are judged, and the distances between them.

    Exits with 1 when a promise was broken, the fleet did not arrive, or verdict.json says otherwise.
    """
    from clew.log.log import fleets_in

    fleets = fleets_in(run)
    if fleets and scene is not None:
        raise UsageError("SCENE: is for a run with one fleet; judge the folder of one fleet with it")
    try:
        ok = _judge_all(run, fleets, as_json=as_json) if fleets else _judge_one(run, scene, as_json=as_json)
    except OSError as error:
        raise UsageError(f"{run}: cannot be read: {error.strerror}") from error
    ctx.exit(0 if ok else 1)


def _judge_one(run: Path, scene: Path | None, *, as_json: bool) -> bool:
    from clew.verbs.judged import judged

    one = judged(run, scene)
    if as_json:
        say_json({"ok": one.ok, **dataclasses.asdict(one.finding), "disagreements": one.wrong})
    else:
        _print(one.finding, one.wrong, ok=one.ok)
    return one.ok


def _judge_all(run: Path, fleets: list[str], *, as_json: bool) -> bool:
    """Judge a run with several fleets."""
    from clew.verbs.judged import judged, judged_between

    each = {name: judged(run / name, None) for name in fleets}
    between, wrong = judged_between(run, each)
    ok = between.ok and not wrong and all(one.ok for one in each.values())
    if as_json:
        said = {name: {"ok": one.ok, **dataclasses.asdict(one.finding)} for name, one in each.items()}
        say_json({"ok": ok, "fleets": said, **dataclasses.asdict(between), "disagreements": wrong})
        return ok
    for name, one in each.items():
        say(f"fleet {name}:")
        _print(one.finding, one.wrong, ok=one.ok)
    say(f"nearest between fleets: {between.nearest or 'none'}")
    for contact in between.contacts:
        say(f"contact: {contact}")
    for difference in wrong or ():
        say(f"the verdict differs: {difference}")
    say(f"{'OK' if ok else 'FAILED'}: {len(each)} fleets, {len(between.contacts)} contacts between them")
    return ok


def _print(finding: "Finding", wrong: list[str] | None, *, ok: bool) -> None:
    for name in ("clearance", "moving_clearance", "separation"):
        least = getattr(finding, name)
        say(f"least {name.replace('_', ' ')}: {'none' if least is None else least}")
    for robot, (x_m, y_m) in finding.places_m.items():
        rank = f"{finding.chain.index(robot) + 1} in the chain" if robot in finding.chain else "in no chain"
        say(f"robot {robot} stands at ({x_m:.4f}, {y_m:.4f}), {rank}")
    if finding.goal_m is not None:
        say(f"nearest to the goal: {finding.goal_m:.4f} m")
    for each in (*finding.broken, *finding.missed):
        say(each)
    for each in wrong or ():
        say(f"the verdict differs: {each}")
    agreed = (
        "there is no verdict" if wrong is None else "the verdict differs" if wrong else "the verdict agrees"
    )
    kept = "broken" if finding.broken else "kept"
    arrived = "not arrived" if finding.missed else "arrived"
    say(f"{'OK' if ok else 'FAILED'}: promises {kept}, {arrived}; {agreed}")
