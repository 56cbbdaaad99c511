"""`clew judge`: judges a run a second time, by true poses and the scene alone."""

import dataclasses
from pathlib import Path
from typing import TYPE_CHECKING

import click
import msgspec

from clew.verbs.options import AS_JSON
from clew.verbs.say import say, say_json
from protocol.errors import UsageError
from protocol.files.opening import MADE_BYTES_MAX, open_regular, read_bytes

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
    least distances with their times, and where each robot stands at the end.

    Exits with 1 when a promise was broken, the fleet did not arrive, or verdict.json says otherwise.
    """
    from clew.judge.agree import disagreements
    from clew.judge.poses import judge
    from clew.judge.truth import UnreadableError, read_run, read_scene_file, scene_of
    from world.judge.verdict import VERDICT_FILE
    from world.record.recorder import EVENTS_FILE

    folder = run if run.is_dir() else run.parent
    try:
        with open_regular(run / EVENTS_FILE if run.is_dir() else run) as lines:
            read = read_run(lines)
        finding = judge(scene_of(read, None if scene is None else read_scene_file(scene)), read)
        wrong = list(disagreements(finding, _verdict(folder))) if (folder / VERDICT_FILE).exists() else None
    except UnreadableError as error:
        raise UsageError(f"{run}: {error}") from error
    except KeyError as error:
        raise UsageError(f"{folder / VERDICT_FILE}: lacks {error}") from error
    except OSError as error:
        raise UsageError(f"{run}: cannot be read: {error.strerror}") from error
    ok = finding.ok and not wrong
    if as_json:
        say_json({"ok": ok, **dataclasses.asdict(finding), "disagreements": wrong})
    else:
        _print(finding, wrong, ok=ok)
    ctx.exit(0 if ok else 1)


def _verdict(folder: Path) -> dict[str, object]:
    from clew.judge.truth import UnreadableError
    from world.judge.verdict import VERDICT_FILE

    try:
        return msgspec.json.decode(read_bytes(folder / VERDICT_FILE, MADE_BYTES_MAX), type=dict[str, object])
    except msgspec.MsgspecError as error:
        raise UnreadableError(f"{VERDICT_FILE}: {error}") from error


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
