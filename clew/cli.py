"""The command line for people: `launch/clew`, and `clew` inside the environment.

Data goes to stdout, everything else to stderr. docs/run.md lists the exit codes.

A Ctrl-C is heard while a verb is loaded and does its work. An earlier one waits until then; a later one
changes nothing.
"""

from protocol.process.loading import hold_interrupts, interruptible, loading

if __name__ == "__main__":
    hold_interrupts()
with loading():
    from protocol.process.streams import open_streams, outlive_readers

    open_streams()
    import contextlib
    import errno
    import os
    import re
    import sys
    from collections.abc import Iterator, Mapping

    import click

    from clew.verbs.group import Late, LateGroup, examples
    from clew.verbs.options import VERSION
    from protocol.errors import UsageError
    from protocol.exit_codes import ExitCode
    from protocol.plain import plain
    from protocol.process.asked import AskedToEnd
    from world.record.recorder import RecordingFailedError

SECTIONS: Mapping[str, Mapping[str, Late]] = {
    "A run": {
        "run": Late("run:run", "Run a fleet as real processes."),
        "rehearse": Late("rehearse:rehearse", "Run a whole fleet in one process, in virtual time."),
        "map": Late("map:map_verb", "Make a scene from a ROS map (map_server)."),
        "ls": Late("ls:ls", "List runs with verdict, size and age; delete them."),
        "fault": Late("fault:fault", "Inject a fault into a running fleet; stop it."),
        "view": Late("view:view", "Serve the page of a run to browsers."),
        "report": Late("report:report", "Write one HTML file that shows a run."),
        "log": Late("log:log", "Read, check, compare and export timelines."),
        "judge": Late("judge:judge_verb", "Judge a run a second time, from true poses."),
        "replay": Late("replay:replay", "Replay all decisions from recorded inputs, and compare."),
        "figures": Late("figures:figures", "Draw figures of a run or campaign, for print."),
        "schema": Late("schema:schema", "Print the JSON Schema of our files, for editors."),
    },
    "Many runs (campaigns, mutants, benchmarks)": {
        "campaign": Late("campaign:campaign", "Rehearse many scenes with many seeds."),
        "compare": Late("compare:compare", "Compare two campaigns, such as those of two laws, or two runs."),
        "shrink": Late("shrink:shrink_verb", "Reduce a failed run's fault plan to what matters."),
        "chaos": Late("chaos:chaos", "Run live fleets under random faults."),
        "mutants": Late("mutants:mutants", "Check that planted bugs are caught."),
        "explore": Late("explore:explore_verb", "Try every schedule with few faults."),
        "bench": Late("bench:bench", "Measure how long things take on this machine."),
        "field": Late("field:field", "Print or write random scenes."),
    },
}


_RANGE = re.compile(r"a valid (integer|float)(?: range)?(?=\.$)")
_NUMBERS = {"integer": "an integer", "float": "a number"}
"""What click calls a range is a number in it."""


class _Refusal(click.ClickException):
    exit_code = ExitCode.USAGE


@contextlib.contextmanager
def _one_line() -> Iterator[None]:
    """Say in one line what is wrong with a command line, and where its help is; or with stdout."""
    try:
        yield
    except click.exceptions.NoArgsIsHelpError:
        raise
    except click.UsageError as error:
        help_is = "" if error.ctx is None else f" ({error.ctx.command_path} -h is its help)"
        said = _RANGE.sub(lambda kind: _NUMBERS[kind[1]], " ".join(error.format_message().split()))
        raise _Refusal(plain(said) + help_is) from error
    except OSError as error:
        if error.filename is not None or error.errno == errno.EPIPE:
            raise
        # An error of a file has its name, so this is of stdout. Python would report it again at exit.
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
        raise click.ClickException(f"cannot write: {error.strerror}") from error


class _Verbs(LateGroup):
    def make_context(
        self, info_name: str | None, args: list[str], parent: click.Context | None = None, **extra: object
    ) -> click.Context:
        outlive_readers()
        with _one_line():
            return super().make_context(info_name, args, parent, **extra)

    def format_commands(self, _ctx: click.Context, formatter: click.HelpFormatter) -> None:
        for title, verbs in SECTIONS.items():
            with formatter.section(title):
                formatter.write_dl([(name, verb.about) for name, verb in verbs.items()])

    def invoke(self, ctx: click.Context) -> object:
        try:
            with interruptible(), _one_line():
                return super().invoke(ctx)
        except UsageError as error:
            raise _Refusal("\n".join(map(plain, str(error).splitlines()))) from error
        except RecordingFailedError as error:  # whose exit code, 1, is click's own
            raise click.ClickException(str(error)) from error
        except AskedToEnd as asked:
            ctx.exit(asked.exit_code)
        except KeyboardInterrupt:
            ctx.exit(ExitCode.INTERRUPTED)


@click.group(
    cls=_Verbs,
    late={name: verb for verbs in SECTIONS.values() for name, verb in verbs.items()},
    context_settings={"help_option_names": ["-h", "--help"]},
    epilog=examples(()),
)
@VERSION
def main() -> None:
    """Run and rehearse fleets of robots, and read and judge their runs."""


if __name__ == "__main__":
    main(prog_name="clew")
