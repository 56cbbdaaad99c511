"""A request for a live run from the words of a command line, for tests."""

from clew.cli import main
from clew.fleet.request import Request
from clew.verbs.run import request_of, run
from tests.support.verbs import context


def asked(*arguments: str) -> Request:
    """The request of `clew run` with these arguments."""
    return request_of(run.make_context("run", list(arguments), parent=context(main)).params)
