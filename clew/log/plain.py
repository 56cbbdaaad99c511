"""What a log says, as it may go to a terminal: a log is anybody's, and a terminal obeys what it is sent."""


def plain(text: str) -> str:
    """The text on one line, whatever does not print (controls, ends of lines, turns of writing) escaped."""
    if text.isprintable():
        return text  # nearly always
    return "".join(each if each.isprintable() else each.encode("unicode_escape").decode() for each in text)
