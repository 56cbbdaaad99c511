"""A run as HTML for a notebook: its verdict in a sentence, and the map with all paths."""

from collections.abc import Sequence
from html import escape
from importlib.util import find_spec

from clew.log.timeline import Timeline
from clew.story.course import course_of
from protocol.errors import UsageError
from world.judge.verdict import Verdict

NO_PICTURE = "(with the extra <code>plot</code>, the map with all paths is here)"
WIDTH_PX = 560  # as wide as a notebook's text on a small screen


def html_of(read: Timeline, said: Sequence[str], verdict: Verdict | None) -> str:
    """The sentences about the run, its verdict's colour, and its picture."""
    colour = "#777" if verdict is None else "#080" if verdict.ok else "#b00"
    first, *rest = map(escape, said)
    head = f'<b style="color:{colour}">{first}</b>' + "".join(f"<br>{each}" for each in rest)
    return f'<div style="max-width:{WIDTH_PX}px">{head}<br>{_picture(read)}</div>'


def _picture(read: Timeline) -> str:
    if find_spec("matplotlib") is None:
        return NO_PICTURE
    # Slow to import, and an extra.
    from clew.figures.region import region  # noqa: PLC0415 - as said above
    from clew.figures.style import render  # noqa: PLC0415 - as said above

    try:
        course = course_of(read)
    except UsageError as error:
        return escape(str(error))
    if len(course.times_s) == 0:
        return "(no body has been placed)"
    svg = render(region(course), ["svg"])["svg"].decode()
    return svg[svg.index("<svg") :].replace("<svg ", '<svg style="width:100%;height:auto" ', 1)
