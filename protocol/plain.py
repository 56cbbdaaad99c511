"""Makes text from robots and logs safe for a terminal, which would execute escape sequences.

Rule 1: all text that is printed for users and comes from a log, a robot or a file goes through `plain`.
"""

import logging


def plain(text: str) -> str:
    """The text on one line; control characters, line breaks and direction marks are escaped."""
    if text.isprintable():
        return text  # the usual case
    return "".join(each if each.isprintable() else each.encode("unicode_escape").decode() for each in text)


class PlainFormatter(logging.Formatter):
    """Formats the messages of a process on stderr."""

    def formatMessage(self, record: logging.LogRecord) -> str:  # noqa: N802 - logging's own name for it
        """The plain line; a traceback of several lines follows unchanged."""
        return plain(super().formatMessage(record))
