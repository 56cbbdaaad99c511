"""The command line for people: `launch/clew`, and `clew` inside the environment.

Data goes to stdout, everything else to stderr. docs/run.md lists the exit codes.
"""

import contextlib
import errno
import os
import sys
from collections.abc import Iterator

import click

from clew.manual.parts import SCHEMAS, schema_line
from clew.verbs.bench import bench
from clew.verbs.bench_busy import busy
from clew.verbs.bench_forming import forming_
from clew.verbs.bench_healing import healing
from clew.verbs.bench_loss import loss
from clew.verbs.campaign import campaign
from clew.verbs.chaos import chaos
from clew.verbs.explore import explore_verb
from clew.verbs.fault import fault
from clew.verbs.field import field
from clew.verbs.figures import figures
from clew.verbs.judge import judge_verb
from clew.verbs.log import log
from clew.verbs.log_cat import cat
from clew.verbs.log_diff import diff
from clew.verbs.log_export import export
from clew.verbs.log_messages import messages
from clew.verbs.log_why import why
from clew.verbs.mutants import mutants
from clew.verbs.options import VERSION, Word
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


@click.command()
@click.argument("what", type=Word(list(SCHEMAS)), default="scenario")
def schema(what: str) -> None:
    """Print the JSON Schema of scenario files or of fault plans, for editors."""
    click.echo(schema_line(what), nl=False)


SECTIONS = {
    "A run": (rehearse, fault, view, report, log, judge_verb, replay, figures, schema),
    "Proving ground (many runs, mutants, benchmarks)": (
        campaign,
        shrink_verb,
        chaos,
        mutants,
        explore_verb,
        bench,
        field,
    ),
}


class _Refusal(click.ClickException):
    exit_code = ExitCode.USAGE


@contextlib.contextmanager
def _one_line() -> Iterator[None]:
    """Say in one line what is wrong with a command line: where its help is, and not how to call it."""
    try:
        yield
    except click.exceptions.NoArgsIsHelpError:
        raise
    except click.UsageError as error:
        help_is = "" if error.ctx is None else f" ({error.ctx.command_path} -h is its help)"
        raise _Refusal(plain(error.format_message()) + help_is) from error


class _Verbs(click.Group):
    def make_context(
        self, info_name: str | None, args: list[str], parent: click.Context | None = None, **extra: object
    ) -> click.Context:
        with _one_line():
            return super().make_context(info_name, args, parent, **extra)

    def format_commands(self, _ctx: click.Context, formatter: click.HelpFormatter) -> None:
        for title, verbs in SECTIONS.items():
            with formatter.section(title):
                formatter.write_dl([(str(verb.name), verb.get_short_help_str(limit=100)) for verb in verbs])

    def invoke(self, ctx: click.Context) -> object:
        try:
            with _one_line():
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
            # An error of a file has its name, so this is of stdout. Python would report it again at exit.
            os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
            raise click.ClickException(f"cannot write: {error.strerror}") from error


@click.group(cls=_Verbs, context_settings={"help_option_names": ["-h", "--help"]})
@VERSION
def main() -> None:
    """Rehearse fleets of robots, and read and judge their runs.

    To start a live fleet, use launch/fleet.sh.
    """


for _verb in (verb for verbs in SECTIONS.values() for verb in verbs):
    main.add_command(_verb)
for _verb in (cat, diff, export, messages, why):
    log.add_command(_verb)
for _verb in (busy, forming_, healing, loss):
    bench.add_command(_verb)


if __name__ == "__main__":
    main(prog_name="clew")
