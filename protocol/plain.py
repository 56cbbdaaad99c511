"""What robots and logs say, as it may go to a terminal, which obeys whatever it is sent.

Rule 1: whatever is printed for people and comes from a log, a robot or a file goes through `plain`.
"""

import logging


def plain(text: str) -> str:
    """The text on one line, whatever does not print (controls, ends of lines, turns of writing) escaped."""
    if text.isprintable():
        return text  # nearly always
    return "".join(each if each.isprintable() else each.encode("unicode_escape").decode() for each in text)


class PlainFormatter(logging.Formatter):
    """For what a process says on stderr."""

    def formatMessage(self, record: logging.LogRecord) -> str:  # noqa: N802 - logging's own name for it
        """The line, plain; a traceback, which has several, stands behind it as it is."""
        return plain(super().formatMessage(record))
