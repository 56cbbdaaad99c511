"""The command line for people: `launch/clew`, and `clew` inside the environment.

Data goes to stdout, the rest to stderr. Exit codes: 0 good, 1 a promise broke or the log is not complete,
2 it cannot be done as asked, 130, 143 or 129 ended by Ctrl-C, SIGTERM or SIGHUP.
"""

import errno
import os
import sys

import click

from clew.manual.parts import SCHEMAS, schema_line
from clew.verbs.bench import bench
from clew.verbs.bench_healing import healing
from clew.verbs.bench_loss import loss
from clew.verbs.campaign import campaign
from clew.verbs.chaos import chaos
from clew.verbs.fault import fault
from clew.verbs.field import field
from clew.verbs.figures import figures
from clew.verbs.log import log
from clew.verbs.log_cat import cat
from clew.verbs.log_diff import diff
from clew.verbs.mutants import oracle
from clew.verbs.rehearse import rehearse
from clew.verbs.replay import replay
from clew.verbs.report import report
from clew.verbs.shrink import shrink_verb
from clew.verbs.view import view
from protocol.asked import AskedToEnd
from protocol.errors import UsageError
from protocol.exit_codes import ExitCode
from protocol.plain import plain
from world.record.recorder import RecordingFailedError


class _Refusal(click.ClickException):
    exit_code = ExitCode.USAGE


class _Verbs(click.Group):
    def invoke(self, ctx: click.Context) -> object:
        try:
            return super().invoke(ctx)
        except UsageError as error:
            raise _Refusal("\n".join(map(plain, str(error).splitlines()))) from error
        except RecordingFailedError as error:  # whose exit code, 1, is click's own
            raise click.ClickException(str(error)) from error
        except AskedToEnd as asked:
            ctx.exit(asked.exit_code)
        except KeyboardInterrupt:
            ctx.exit(ExitCode.INTERRUPTED)
        except OSError as error:
            if error.filename is not None or error.errno == errno.EPIPE:
                raise
            # What was opened is named, so this is stdout: Python would complain once more at its end.
            os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
            raise click.ClickException(f"cannot write: {error.strerror}") from error


@click.group(cls=_Verbs)
def main() -> None:
    """Clew: rehearse fleets, read and judge their runs. Start a live one with launch/fleet.sh."""


@main.command()
@click.argument("what", type=click.Choice(list(SCHEMAS)), default="scenario")
def schema(what: str) -> None:
    """Print the JSON Schema of a scenario file, or of a fault plan, for editors."""
    click.echo(schema_line(what), nl=False)


for _verb in (
    rehearse,
    campaign,
    chaos,
    field,
    bench,
    log,
    fault,
    replay,
    shrink_verb,
    oracle,
    view,
    figures,
    report,
):
    main.add_command(_verb)
for _verb in (cat, diff):
    log.add_command(_verb)
for _verb in (healing, loss):
    bench.add_command(_verb)


if __name__ == "__main__":
    main(prog_name="clew")
