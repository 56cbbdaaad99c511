"""`clew explore`: every schedule with few faults, of the cores that ship, in a small world."""

from typing import TYPE_CHECKING

import click

from clew.verbs.options import AS_JSON, FiniteRange, Word, robots_option
from clew.verbs.say import console, numbers_table, say_json, warn
from protocol.exit_codes import ExitCode

if TYPE_CHECKING:
    from rich.table import Table

    from clew.explore.explore import Round
    from clew.explore.setting import Setting

SETTING_NAMES = ("start", "turns", "drive", "heal", "cut", "middle", "orders", "rejoin", "round", "late")
FIRST = SETTING_NAMES[0]  # explored where none is named
RULE_NAMES = ("F1", "F2", "F3", "F4", "F5", "F6")


@click.command("explore")
@click.argument("setting", type=Word(SETTING_NAMES), required=False)
@robots_option("Number of robots, at most the setting's.")
@click.option(
    "--faults", type=click.IntRange(0, 4), help="Explore all schedules with at most this many faults."
)
@click.option(
    "--deliveries",
    type=click.IntRange(1, 10_000),
    help="Faults occur during this many delivered messages, counted without faults.",
)
@click.option("--skip", type=click.IntRange(0, 10_000), help="Faults occur only after this many messages.")
@click.option(
    "--recovers", is_flag=True, help="After the faults all robots that live have to form a strand and drive."
)
@click.option(
    "--without",
    "rule",
    type=Word(RULE_NAMES),
    help="Remove this rule from a copy of the source: F1 obedience, F2 in force, F3 one mover, "
    "F4 one formation, F5 authority, F6 sight.",
)
@click.option(
    "--seconds",
    type=FiniteRange(0.0, min_open=True),
    default=60.0,
    show_default=True,
    help="Limit for all of it [CPU s].",
)
@AS_JSON
@click.pass_context
def explore_verb(
    ctx: click.Context,
    setting: str | None,
    *,
    robots: int | None,
    faults: int | None,
    deliveries: int | None,
    skip: int | None,
    recovers: bool,
    rule: str | None,
    seconds: float,
    as_json: bool,
) -> None:
    """Try every schedule with few faults, on the real cores, in a small world without noise.

    SETTING is what the robots do; default: start. Without faults messages are delivered in order and at
    once. Each lost, late or repeated message, each kill, cut and restart is one fault. The verb explores
    without faults, then with one, and so on, and says what was covered. It exits with 1 when a promise is
    broken, and prints a schedule with as few faults as possible. With --without a rule is removed first, in
    the setting that shows it; then it exits with 1 if no promise is broken.
    """
    from clew.explore.explore import explore, story
    from clew.explore.search import Ended
    from clew.explore.setting import SETTINGS, adjusted
    from clew.explore.without import RULES, explore_without

    if rule is not None:
        _refuse_with_rule(setting, robots, faults, deliveries, skip, recovers or None)
        chosen, rounds = RULES[rule].setting, explore_without(rule, seconds)
    else:
        chosen = adjusted(SETTINGS[setting or FIRST], robots=robots, deliveries=deliveries, skips=skip)
        if recovers and not chosen.has_way_for_all:
            raise click.UsageError("--recovers: is for settings with a way for all robots")
        rounds = explore(chosen, chosen.faults if faults is None else faults, seconds, recovers=recovers)
    done: list[Round] = []
    for each in rounds:
        done.append(each)
        warn(f"explore: {_sentence(each)}")
    last = done[-1].explored
    if as_json:
        say_json(done)
    else:
        console().print(_table(chosen, done))
        if last.broken is not None and rule is None:
            for line in story(chosen, last.broken.strikes, recovers=recovers):
                click.echo(line)
    broken = last.ended is Ended.BREACH
    ctx.exit(ExitCode.FAILED if broken is (rule is None) else ExitCode.OK)


def _refuse_with_rule(*given: object) -> None:
    """Refuse what the setting of a rule decides."""
    if any(each is not None for each in given):
        raise click.UsageError(
            "--without: explores the setting that shows the rule, so SETTING, --robots, --faults, "
            "--deliveries, --skip and --recovers must not be given"
        )


def _sentence(each: "Round") -> str:
    from clew.explore.search import Ended
    from protocol.timeline.invariants import named

    explored = each.explored
    faults = "1 fault" if explored.faults == 1 else f"{explored.faults} faults"
    if explored.broken is not None:
        return f"{named(explored.broken.promise)} breaks with {faults}: {explored.broken.why}"
    covered = "all" if explored.ended is Ended.COMPLETE else "not all, since time was up, of the"
    sentence = f"{covered} schedules with {faults} at most: {explored.states:,} states, no breach"
    slowest = "" if each.slowest_s is None else f", recovered within {each.slowest_s:.1f} s"
    return sentence + slowest


def _table(setting: "Setting", done: "list[Round]") -> "Table":
    from clew.explore.search import Ended

    drawn = numbers_table(
        "faults at most", "schedules", "states", "transitions", "depth", "ended", "CPU, s",
        left=("ended", "CPU, s"),
        title=f"{setting.name}: {setting.about}; faults in {setting.deliveries} deliveries",
    )  # fmt: skip
    for each in done:
        explored = each.explored
        schedules = f"{sum(explored.schedules):,}" if explored.ended is Ended.COMPLETE else "-"
        drawn.add_row(
            str(explored.faults),
            schedules,
            f"{explored.states:,}",
            f"{explored.transitions:,}",
            str(explored.depth),
            str(explored.ended),
            f"{each.cpu_s:.1f}",
        )
    return drawn
