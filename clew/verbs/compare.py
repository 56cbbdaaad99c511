"""`clew compare`: two campaigns, or two runs, against each other, measure by measure."""

from collections.abc import Iterable, Iterator
from pathlib import Path
from typing import TYPE_CHECKING

import click

from clew.verbs.options import AS_JSON, PATH
from clew.verbs.say import console, many, numbers_table, say, say_json, warn
from protocol.errors import UsageError

if TYPE_CHECKING:
    from rich.table import Table
    from rich.text import Text

    from clew.api import outcomes
    from clew.campaign.compare import Asked, Compared, Paired
    from clew.campaign.episode import Outcome

SHOWN = {
    "no_promise_broken": ("no promise broken [%]", 100.0),
    "arrived": ("arrived [%]", 100.0),
    "sim_s": ("time [s]", 1.0),
    "path_m": ("driven by all [m]", 1.0),
    "switching_steps": ("switching steps", 1.0),
    "events_per_m": ("planning events [1/m]", 1.0),
    "clearance_margin_m": ("margin of clearance [mm]", 1000.0),
}
"""Each measure of campaigns for people: its name with its unit, and how many of that unit are one of SI."""
OF_PAIRS = {"sim_s": ("time s", 2), "switching_steps": ("steps", 0), "clearance_margin_m": ("margin mm", 2)}
"""What a pair of episodes shows: the name for people, and how many digits it has after the point."""
OF_RUNS = {
    "robots_arrived": ("robots arrived", 0),
    "violations": ("promises broken", 0),
    "sim_s": ("time [s]", 2),
    "path_m": ("driven by all [m]", 2),
    "switching_steps": ("switching steps", 0),
    "planning_events": ("planning events", 0),
    "clearance_m_min": ("least clearance [m]", 4),
    "moving_clearance_m_min": ("least distance to what moves [m]", 4),
    "separation_m_min": ("least separation [m]", 4),
    "messages_sent": ("messages sent", 0),
    "lost_to_faults": ("messages lost to faults", 0),
    "noticed_s": ("death noticed after [s]", 2),
    "healed_s": ("death healed after [s]", 2),
}
"""Each measure of runs for people: its name with its unit, and how many digits it has after the point."""


@click.command()
@click.argument("a", metavar="A", type=PATH)
@click.argument("b", metavar="B", type=PATH)
@click.option(
    "--each", is_flag=True, help="Of two campaigns: also show each pair of episodes, B's worst first."
)
@AS_JSON
def compare(*, a: Path, b: Path, each: bool, as_json: bool) -> None:
    """Compare two campaigns or two runs, A and B: for example, two laws on the same scenes.

    Of two runs, for example a live one and its rehearsal, it shows what came of them, what was asked
    differently, and the first switching step that differs.

    Of two campaigns, episodes of the same family, scene and seed are paired. Each difference, B - A, has a
    95 % confidence interval over scenes. Shares are of all pairs, other measures of the pairs in which both
    fleets arrived.
    """
    from clew.campaign.compare import compare as compared
    from clew.log.log import check_run_or_campaign

    for each_of_two in (a, b):
        check_run_or_campaign(each_of_two)
    if _is_run(a) and _is_run(b):
        if each:
            raise UsageError("--each is for two campaigns, and A and B are runs")
        _compare_runs(a, b, as_json=as_json)
        return
    for one, other in ((a, b), (b, a)):
        if _is_run(one):
            raise UsageError(f"{other}: is no run, and {one} is one; compare two runs, or two campaigns")
    (ours, a_asked), (theirs, b_asked) = map(_read, (a, b))
    found = compared(ours, theirs, (a_asked, b_asked))
    if as_json:
        say_json(found)
        return
    if each:
        console().print(_table_of_pairs(found.each))
    console().print(_table(found.measures))
    for name, (one, other) in found.asked.items():
        say(f"asked differently: {name}: A {_said(one)}, B {_said(other)}")
    left = f"; only in A: {found.only_a}, only in B: {found.only_b}" if found.only_a or found.only_b else ""
    say(f"{many(found.pairs, 'pair')} of {many(found.scenes, 'scene')}{left}. A: {a}, B: {b}")


def _is_run(path: Path) -> bool:
    from world.record.recorder import EVENTS_FILE

    return (path / EVENTS_FILE).is_file() or path.name == EVENTS_FILE


def _compare_runs(a: Path, b: Path, *, as_json: bool) -> None:
    from clew.api.compare import compare as compared
    from clew.api.run import open_run
    from clew.fleet.summary import verdict_sentence

    one, other = map(open_run, (a, b))
    both = compared(one, other)
    if as_json:
        first = None if both.first is None else {"step": both.first.number, "apart": both.first.apart}
        say_json({"asked": both.asked, "outcomes": both.outcomes, "first": first})
        return
    if both.outcomes:
        drawn = numbers_table("measure", "A", "B", "B - A", left=("measure",))
        for each in both.outcomes:
            drawn.add_row(*_row(each))
        console().print(drawn)
    for letter, run, path in (("A", one, a), ("B", other, b)):
        said = "no verdict yet" if run.verdict is None else verdict_sentence(run.verdict, run.scenario)
        say(f"{letter}: {path}: {said}")
    say(str(both))


def _row(outcome: "outcomes.Outcome") -> "Iterator[Text]":
    from rich.text import Text  # as in `_table`

    name, digits = OF_RUNS[outcome.measure]
    yield Text(name if outcome.robot is None else f"r{outcome.robot}: {name}")
    for figure, sign in ((outcome.a, ""), (outcome.b, ""), (outcome.difference, "+")):
        yield Text("-" if figure is None else format(round(figure, digits) + 0.0, f"{sign}.{digits}f"))


def _read(folder: Path) -> "tuple[tuple[Outcome, ...], Asked]":
    """The outcomes of a campaign, and what was asked of it where `campaign.json` says so.

    Raises:
        UsageError: there is no campaign, or none that can be read.
    """
    import msgspec

    from clew.campaign.campaign import CAMPAIGN_FILE, EPISODES_FILE
    from clew.campaign.compare import Asked
    from clew.figures.outcomes import read_campaign
    from protocol.files.opening import MADE_BYTES_MAX, read_bytes

    path = folder / CAMPAIGN_FILE if folder.is_dir() else folder
    if not path.exists() and not path.with_name(EPISODES_FILE).exists():
        raise UsageError(f"{folder}: is neither a run nor a campaign")
    outcomes, flaws = read_campaign(path)
    for flaw in flaws:
        warn(f"{folder}: not complete: {flaw}")
    try:
        return outcomes, msgspec.json.decode(read_bytes(path, MADE_BYTES_MAX), type=Asked)
    except (OSError, msgspec.MsgspecError):
        return outcomes, Asked()


def _table(measures: "Iterable[Compared]") -> "Table":
    from rich.text import Text  # [s] in a plain text would be markup

    columns = ("pairs", "counted", "A", "B", "B - A", "95 % from", "to")
    drawn = numbers_table("measure", *columns, left=("measure",))
    for each in measures:
        name, per_si = SHOWN[each.measure]
        values = (
            _cell(each.a, per_si),
            _cell(each.b, per_si),
            *(_cell(value, per_si, sign="+") for value in (each.difference, each.low, each.high)),
        )
        drawn.add_row(Text(name), str(each.pairs), str(each.counted), *values)
    return drawn


def _table_of_pairs(pairs: "Iterable[Paired]") -> "Table":
    from rich.text import Text  # as in `_table`

    columns = [f"{name} {which}" for name, _ in OF_PAIRS.values() for which in "AB"]
    drawn = numbers_table("scene", "seed", "arrived", *columns, left=("scene", "arrived"))
    drawn.columns[0].overflow = "fold"  # a name is to be found again
    for each in pairs:
        arrived = " ".join(which for which, it in (("A", each.a), ("B", each.b)) if it["arrived"])
        values = [
            _cell(it[measure], SHOWN[measure][1], digits=digits)
            for measure, (_, digits) in OF_PAIRS.items()
            for it in (each.a, each.b)
        ]
        drawn.add_row(Text(f"{each.family}/{each.scene}"), str(each.seed), arrived or "none", *values)
    return drawn


def _cell(value: float | None, per_si: float, sign: str = "", digits: int = 2) -> str:
    return "-" if value is None else format(value * per_si, f"{sign}.{digits}f")


def _said(value: object) -> str:
    return "as each scene says" if value is None else str(value)
