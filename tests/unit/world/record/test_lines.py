"""Reading a line gives the entry that was written, for all kinds."""

from typing import get_args

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from protocol.timeline import Entry, Record
from protocol.timeline.base import Kind
from tests.support.strategies.message_strategies import values_of
from world.record.lines import read_line
from world.record.recorder import line


@pytest.mark.parametrize("kind", get_args(Record))
@given(data=st.data())
@settings(max_examples=10)
def test_an_entry_survives_writing_and_reading(kind: type[Kind], data: st.DataObject) -> None:
    entry = Entry(n=7, t_s=1.25, hlc="1/r3", record=data.draw(values_of(kind)))
    assert read_line(line("r3", entry)) == ("r3", entry)
