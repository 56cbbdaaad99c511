from msgspec.structs import replace

from protocol.timeline import Entry, LinkBroken, RobotFailed, StepAbandoned, StrandReversed
from tests.support.planned import planned
from world.record.progress import progress


def test_only_a_leaders_step_is_told_by_its_number() -> None:
    leads, joins = planned(3), replace(planned(1), joins=True)
    told = [progress("r2", Entry(n=1, t_s=1.0, hlc="", record=record)) for record in (leads, joins)]
    assert told == ["t=   1.0 s  r2 plans step 3: 1.000 m", "t=   1.0 s  r2 goes 1.000 m towards its place"]


def test_what_breaks_a_strand_is_told() -> None:
    records = (
        LinkBroken(neighbour=1, cause="token", silent_s=0.84),
        RobotFailed(reason="ValueError"),
        StepAbandoned(step=3, epoch=1, x_m=0.0, y_m=0.0),
        StrandReversed(epoch=1, cut_m=0.0, end_m=1.0, back_by_m=0.0),
    )
    told = [progress("r2", Entry(n=1, t_s=1.0, hlc="", record=record)) for record in records]
    assert told == [
        "t=   1.0 s  r2 gives up its link to r1, silent for 0.8 s",
        "t=   1.0 s  r2 has failed: ValueError",
        "t=   1.0 s  r2 stops short in step 3",
        "t=   1.0 s  r2 has the strand turn round",
    ]
