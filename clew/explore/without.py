"""The rules of the fence, each removed from a copy of the source: the exploration has to find what breaks."""

import sys
from collections.abc import Iterator
from pathlib import Path
from tempfile import TemporaryDirectory

import msgspec
from msgspec import Struct
from msgspec.structs import replace

from clew.campaign.mutants import apply, started
from clew.campaign.mutants_list import Edit, Mutant
from clew.explore.explore import Round
from clew.explore.setting import NEVER_TICKS, SETTINGS, Kind, Setting
from protocol.errors import UsageError


class Without(Struct, frozen=True, kw_only=True):
    """A rule, the edits that remove it, and the smallest setting that shows that it is gone."""

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


def _without(name: str, rule: str, setting: Setting, *edits: tuple[str, str, str]) -> Without:
    return Without(mutant=Mutant(name, rule, tuple(Edit(*edit) for edit in edits)), setting=setting)


# An order is late, and its robot dies: the others propose a view, and the order arrives.
LATE_ORDER = _in("drive", deliveries=12, kinds=(Kind.LATE, Kind.KILL), delays_ticks=(20,))
# The put of ALL is late, after the members have been told the formation.
LATE_ALL = _in("start", skips=31, deliveries=4, kinds=(Kind.LATE,))
# A turn that names nobody arrives once more, after the ALL that follows it.
OLD_TURN = _in("turns", skips=92, deliveries=20, kinds=(Kind.LATE, Kind.TWICE))
# A scan is late, and meanwhile the world is started again.
OLD_SCAN = _in("start", skips=45, deliveries=16, kinds=(Kind.LATE, Kind.WORLD))

RULES = {
    each.mutant.name: each
    for each in (
        _without(
            "F1",
            "a body moves only by an order that bears exactly its fence",
            LATE_ORDER,
            (
                "protocol/fence.py",
                "    return exactly and fence.names(robot, bearing.life)",
                "    return True",
            ),
            (
                "protocol/fence.py",
                "    exactly = (bearing.epoch, bearing.turn) == (fence.epoch, fence.turn)\n",
                "",
            ),
        ),
        _without(
            "F2",
            "a robot orders motion only under a fence that is in force",
            LATE_ALL,
            (
                "agents/body/driver.py",
                "return self._odometry is not None and self._is_told(self._bearing) and",
                "return self._odometry is not None and",
            ),
            (
                "agents/membership/membership.py",
                "if self.state is State.BOUND and self._fence.may is May.ALL:",
                "if self.state is State.BOUND:",
            ),
            (
                "agents/membership/membership.py",
                "if whole is None or whole[0].turn != self._fence.turn or not in_force(self._fence):",
                "if whole is None:",
            ),
        ),
        _without(
            "F3",
            "the register takes exactly the next turn, and none after ALL",
            OLD_TURN,
            (
                "world/bodies/fence.py",
                "is_next = (fence.epoch, fence.turn) == (now.epoch, now.turn + 1) and now.may is not May.ALL",
                "is_next = fence.epoch == now.epoch and fence != now",
            ),
        ),
        _without(
            "F4",
            "a place in a formation is newer than the last turn of its robot",
            _in("turns", deliveries=1),
            (
                "agents/coordinating/coordinator.py",
                "        self._reported.count(robot, report)\n",
                "        kept = {} if known is None else {'place': known.place}\n"
                "        report = __import__('msgspec').structs.replace(report, **kept)\n"
                "        self._reported.count(robot, report)\n",
            ),
        ),
        _without(
            "F5",
            "under ALL, a robot drives only as far as its authority",
            _in("start", deliveries=1),
            (
                "agents/strand/strand.py",
                "self.authority_m = max(self.authority_m, state.authority_m)",
                "self.authority_m = self.path.end_m",
            ),
        ),
        _without(
            "F6",
            "a scan serves only under the very fence that it bears",
            OLD_SCAN,
            (
                "agents/body/senses.py",
                "return scan.fence == fence and in_force(fence)",
                "return in_force(fence)",
            ),
            ("agents/membership/membership.py", "        self._senses.forget()\n", ""),
        ),
    )
}


def explore_without(rule: str, seconds: float) -> Iterator[Round]:
    """Explore the setting of a rule in a copy of the source without it.

    Raises:
        UsageError: the source has changed, and the edits must follow; or the copy does not start.
    """
    with TemporaryDirectory(prefix="clew-without-") as folder:
        apply(RULES[rule].mutant, Path(folder))
        command = [sys.executable, "-m", "clew.explore", rule, str(seconds)]
        with started(command, Path(folder)) as process:
            assert process.stdout is not None, "opened as a pipe"
            for line in process.stdout:
                yield msgspec.json.decode(line, type=Round)
            if process.wait() != 0:
                assert process.stderr is not None, "opened as a pipe"
                last_words = process.stderr.read().decode(errors="replace").strip().splitlines()[-1:]
                raise UsageError(f"the source without {rule} does not start: {' '.join(last_words)}")
