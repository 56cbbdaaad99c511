"""The base of all kinds of timeline entries."""

from typing import Annotated

from msgspec import Meta, Struct

from protocol.frames import Count

Text = Annotated[str, Meta(max_length=2000)]
Counts = Annotated[dict[Annotated[str, Meta(max_length=200)], Count], Meta(max_length=20_000)]


class Kind(Struct, frozen=True, kw_only=True, tag_field="kind"):
    """The base of all kinds; the fields of `Entry` come before its own."""
