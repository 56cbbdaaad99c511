from typing import get_args

from clew.manual.timeline import DOCUMENT, document
from protocol.timeline import Record


def test_the_page_is_what_the_types_say() -> None:
    assert DOCUMENT.read_text(encoding="utf-8") == document(), "run: python -m clew.manual.timeline"


def test_every_kind_and_every_field_stands_in_the_page() -> None:
    page = document()
    for kind in get_args(Record):
        section = page.split(f"### `{kind.__struct_config__.tag}`\n")[1].split("###")[0]
        assert [field for field in kind.__struct_fields__ if f"| `{field}` |" not in section] == []
