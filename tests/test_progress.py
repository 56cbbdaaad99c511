from msgspec.structs import replace

from protocol.timeline import Entry
from tests.test_strokes import planned
from world.progress import progress


def test_only_a_leaders_step_is_told_by_its_number() -> None:
    leads, joins = planned(3), replace(planned(1), joins=True)
    told = [progress("r2", Entry(n=1, t_s=1.0, hlc="", record=record)) for record in (leads, joins)]
    assert told == ["t=   1.0 s  r2 plans step 3: 1.000 m", "t=   1.0 s  r2 goes 1.000 m towards its place"]
