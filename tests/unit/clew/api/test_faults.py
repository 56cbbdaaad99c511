"""Faults as functions make the rules of fault plans."""

import re
from collections.abc import Callable
from functools import partial

import pytest

from clew.api import faults
from protocol.errors import UsageError
from protocol.faults.plan import Plan
from protocol.faults.rules import (
    Corrupt,
    Delay,
    Drop,
    Duplicate,
    Freeze,
    Kill,
    Partition,
    Reorder,
    Restart,
    Rule,
    Slow,
    StepPoint,
    Thaw,
)

MADE: list[tuple[Rule, Rule]] = [
    (
        faults.drop("ahead", p=0.3, sender=1, receiver=["r2", 3]),
        Drop(kinds=("ahead",), probability=0.3, sender=("r1",), receiver=("r2", "r3")),
    ),
    (faults.delay(max_s=0.4, min_s=0.1, from_s=1.0), Delay(delay_s_max=0.4, delay_s_min=0.1, from_s=1.0)),
    (faults.duplicate(copies=3, until_s=9.0), Duplicate(copies=3, until_s=9.0)),
    (faults.reorder(hold_s=0.2, step=2, until_step=4), Reorder(hold_s=0.2, from_step=2, until_step=4)),
    (faults.corrupt(bits=2, truncate=True), Corrupt(bits=2, truncate=True)),
    (
        faults.partition([1, 2], "r3", one_way=True),
        Partition(group=("r1", "r2"), others=("r3",), one_way=True),
    ),
    (
        faults.kill("leader", at="after_plan", step=2, name="dies"),
        Kill(target="leader", point=StepPoint.AFTER_PLAN, from_step=2, name="dies"),
    ),
    (faults.freeze(3, for_s=2.0), Freeze(target="r3", for_s=2.0)),
    (faults.thaw("tail", from_s=5.0), Thaw(target="tail", from_s=5.0)),
    (faults.restart("router", after_s=1.0), Restart(target="router", after_s=1.0)),
    (faults.slow("middle", by_s=0.2, for_s=1.0), Slow(target="middle", delay_s=0.2, for_s=1.0)),
]


@pytest.mark.parametrize(("made", "rule"), MADE, ids=[rule.fault for _, rule in MADE])
def test_a_function_makes_the_rule(made: Rule, rule: Rule) -> None:
    assert made == rule
    assert Plan(name="one", rules=(made,)).names == [rule.name or f"{rule.fault}-1"]


def test_a_wrong_field_is_refused_in_one_line() -> None:
    with pytest.raises(UsageError, match=r"clew.kill: \$.point: .*after_lunch"):
        faults.kill("leader", at="after_lunch")
    with pytest.raises(UsageError, match=r"clew.partition: \$.group"):
        faults.partition(())
    for nobody in (3.0, [1, 2]):
        with pytest.raises(UsageError, match=r"clew.kill: \$.target: must be a string, got "):
            faults.kill(nobody)  # type: ignore[arg-type] # as a user may write it
    with pytest.raises(UsageError, match=r"clew.drop: \$.from\[0\]: must be a string, got 3.0"):
        faults.drop(sender=3.0)  # type: ignore[arg-type] # as a user may write it


def test_a_probability_in_the_place_of_a_kind_is_told_its_name() -> None:
    with pytest.raises(
        UsageError, match=r"^clew\.drop: kinds of message come first, got 0\.3; did .* p=0\.3\?$"
    ):
        faults.drop(0.3)  # type: ignore[arg-type] # as a user may write it
    with pytest.raises(UsageError, match=r"clew\.drop: \$\.kind\[0\]: must be a string, got 0\.3"):
        faults.drop(0.3, p=0.5)  # type: ignore[arg-type] # as a user may write it


@pytest.mark.parametrize(
    ("make", "wrong", "near"),
    [
        (faults.drop, "prob", "; did you mean 'p'?"),
        (faults.drop, "to", "; did you mean 'receiver'?"),
        (faults.drop, "from_step", "; did you mean 'step'?"),
        (partial(faults.delay, max_s=1.0), "mins_s", "; did you mean 'min_s'?"),
        (partial(faults.kill, 1), "until", "; did you mean 'until_s'?"),
        (partial(faults.kill, 1), "p", ""),
    ],
)
def test_an_argument_that_is_none_is_refused_by_the_words_of_python(
    make: Callable[..., Rule], wrong: str, near: str
) -> None:
    with pytest.raises(UsageError) as refused:
        make(**{wrong: 0.2})
    assert re.fullmatch(
        rf"clew\.\w+: must have no argument but .*\bstep, until_step, name(, p, sender, receiver)?, "
        rf"got {wrong}=0\.2{re.escape(near)}",
        str(refused.value),
    )
