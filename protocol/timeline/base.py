"""The base of all kinds of timeline entries."""

from typing import Annotated

from msgspec import Meta, Struct

from protocol.frames import ROBOTS_MAX, Count

Robot = Annotated[int, Meta(ge=0, le=ROBOTS_MAX)]
LifeText = Annotated[str, Meta(pattern="^[0-9a-f]{0,16}$")]
Text = Annotated[str, Meta(max_length=2000)]
Counts = Annotated[dict[Annotated[str, Meta(max_length=200)], Count], Meta(max_length=20_000)]


class Kind(Struct, frozen=True, gc=False, kw_only=True, tag_field="kind"):
    """The base of all kinds; the fields of `Entry` come before its own."""
