"""The rules of the fence, each removed from a copy of the source: the exploration has to find what breaks."""

from collections.abc import Iterator
from pathlib import Path
from tempfile import TemporaryDirectory

from msgspec import Struct
from msgspec.structs import replace

from clew.explore.explore import Round
from clew.explore.setting import NEVER_TICKS, SETTINGS, Kind, Setting
from clew.mutants.list import mutant_named
from clew.mutants.mutant import Mutant
from clew.mutants.run import apply, told_in


class Without(Struct, frozen=True, kw_only=True):
    """The mutant without a rule, and the smallest setting that shows that the rule is gone."""

    mutant: Mutant
    setting: Setting


def _in(
    name: str,
    *,
    deliveries: int = 1,
    skips: int = 0,
    kinds: tuple[Kind, ...] = (),
    delays_ticks: tuple[int, ...] = (5,),
) -> Setting:
    """A setting with few faults, so that what is wrong is found soon; nobody is started again."""
    return replace(
        SETTINGS[name],
        deliveries=deliveries,
        skips=skips,
        kinds=kinds,
        delays_ticks=delays_ticks,
        restarts_ticks=(NEVER_TICKS,),
    )


# An order is late, and its robot dies: the others propose a view, and the order arrives.
LATE_ORDER = _in("drive", deliveries=12, kinds=(Kind.LATE, Kind.KILL), delays_ticks=(20,))
# The put of ALL is late, after the members have been told the formation.
LATE_ALL = _in("start", skips=31, deliveries=4, kinds=(Kind.LATE,))
# A turn that names nobody arrives once more, after the ALL that follows it.
OLD_TURN = _in("turns", skips=92, deliveries=20, kinds=(Kind.LATE, Kind.TWICE))
# A scan is late, and meanwhile the world is started again.
OLD_SCAN = _in("start", skips=45, deliveries=16, kinds=(Kind.LATE, Kind.WORLD))

RULES = {
    rule: Without(mutant=mutant_named(name), setting=setting)
    for rule, name, setting in (
        ("F1", "any-order", LATE_ORDER),
        ("F2", "orders-untold", LATE_ALL),
        ("F3", "any-turn", OLD_TURN),
        ("F4", "old-places", _in("turns", deliveries=1)),
        ("F5", "path-is-authority", _in("start", deliveries=1)),
        ("F6", "old-scans", OLD_SCAN),
    )
}


def explore_without(rule: str, seconds: float) -> Iterator[Round]:
    """Explore the setting of a rule in a copy of the source without it.

    Raises:
        UsageError: the source has changed, and the edits must follow; or the copy does not start.
    """
    with TemporaryDirectory(prefix="clew-without-") as folder:
        apply(RULES[rule].mutant, Path(folder))
        yield from told_in(Path(folder), ["clew.explore", rule, str(seconds)], Round)
