"""A second opinion on an episode: that of the judge of poses, which shares no code with the world's.

It gets the lines that `events.jsonl` would hold, and nothing else of the rehearsal.
"""

from collections.abc import Iterator

import msgspec

from clew.judge.agree import disagreements
from clew.judge.poses import judge
from clew.judge.truth import read
from clew.rehearsal.recorded import EPOCH
from clew.rehearsal.rehearsal import Rehearsal
from protocol.timeline import FaultInjected, PoseSampled
from world.judge.verdict import Verdict
from world.record.recorder import line
from world.record.run_files import header_of
from world.scenario.scenario import Scenario


def second_opinion(scenario: Scenario, rehearsal: Rehearsal, verdict: Verdict) -> str | None:
    """In what true poses contradict the verdict first; None: in nothing."""
    try:
        finding = judge(read(_lines(scenario, rehearsal)))
    except Exception as error:  # an episode has an outcome even if the judge has a bug
        return f"the second judge fails: {type(error).__name__}: {error}"
    return next(disagreements(finding, msgspec.to_builtins(verdict)), None)


def _lines(scenario: Scenario, rehearsal: Rehearsal) -> Iterator[bytes]:
    header = header_of(scenario, rehearsal.plan, run="", seed=0, speed=None, started_at=EPOCH, hlc="")
    yield msgspec.json.encode(header) + b"\n"
    for source, entry in rehearsal.entries:
        if isinstance(entry.record, PoseSampled | FaultInjected):  # it reads no others
            yield line(source, entry)
