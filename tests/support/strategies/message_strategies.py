"""Hypothesis strategies for the wire's types, derived from their annotations so that no type is missed."""

import math
from typing import Any, get_args

import msgspec
from hypothesis import strategies as st
from msgspec import inspect

from protocol.faults.plan import uniform
from protocol.faults.rules import Corrupt, Freeze, Kill, Partition, Reorder, Restart, Rule, Slow, Thaw
from protocol.wire.messages import Message

MESSAGE_TYPES: tuple[type[msgspec.Struct], ...] = get_args(Message)
# Most combinations of valid fields make no valid rule.
RULES: dict[type, Rule] = {
    type(rule): rule
    for rule in (
        *uniform(loss=0.5, delay_s_max=1.0, repeat=0.1).rules,
        Reorder(hold_s=1.0),
        Corrupt(bits=2, truncate=True),
        Partition(group=("r1",), others=("router",), period_s=2.0, cut_s=1.0),
        Kill(target="leader", robots=2),
        Freeze(target="r1", for_s=1.0),
        Thaw(target="r1"),
        Restart(target="world"),
        Slow(target="tail", delay_s=1.0),
    )
}
SEQUENCE_LENGTH_MAX = 4  # enough to tell none, one and many apart; the size limit has its own test


def values_of(kind: Any) -> st.SearchStrategy[Any]:  # noqa: ANN401 - any type of ours
    """Values of a type that keep all its bounds."""
    return _values(inspect.type_info(kind))


def messages() -> st.SearchStrategy[Message]:
    """Messages of every type."""
    return st.one_of([values_of(kind) for kind in MESSAGE_TYPES])


def _values(info: inspect.Type) -> st.SearchStrategy[Any]:  # noqa: C901, PLR0911, PLR0912 - one line a case
    match info:
        case inspect.Metadata():
            return _values(info.type)
        case inspect.StructType() if info.cls in RULES:
            return st.just(RULES[info.cls])
        case inspect.StructType():
            return st.builds(info.cls, **{field.name: _values(field.type) for field in info.fields})
        case inspect.IntType():
            return st.integers(info.ge, info.le)
        case inspect.FloatType():
            low, high = info.gt if info.ge is None else info.ge, info.le
            least, most = -math.inf if low is None else low, math.inf if high is None else high
            return st.floats(least, most, exclude_min=info.gt is not None)
        case inspect.StrType(pattern=None):
            return st.text(max_size=min(info.max_length or 20, 20))
        case inspect.StrType():
            assert info.pattern is not None
            return st.from_regex(info.pattern, fullmatch=True)
        case inspect.BytesType():
            return st.binary(max_size=min(info.max_length or 20, 20))
        case inspect.BoolType():
            return st.booleans()
        case inspect.NoneType():
            return st.none()
        case inspect.LiteralType():
            return st.sampled_from(info.values)
        case inspect.EnumType():
            return st.sampled_from(list(info.cls))
        case inspect.UnionType():
            return st.one_of([_values(each) for each in info.types])
        case inspect.VarTupleType():
            least, most = info.min_length or 0, info.max_length or SEQUENCE_LENGTH_MAX
            few = max(least, min(most, SEQUENCE_LENGTH_MAX))
            return st.lists(_values(info.item_type), min_size=least, max_size=few).map(tuple)
        case inspect.DictType():
            return st.dictionaries(_values(info.key_type), _values(info.value_type), max_size=4)
        case _:
            raise NotImplementedError(info)
