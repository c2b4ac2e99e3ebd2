# SPDX-FileCopyrightText: 2026 The tumtools authors
# SPDX-License-Identifier: MIT
"""The program: a table of commands that are imported when they run, and what becomes of errors."""

from __future__ import annotations

import os
import signal
import sys
from importlib import import_module
from io import TextIOWrapper
from pathlib import Path
from time import perf_counter
from typing import Final, NoReturn, cast

import click

from tumtools import __version__
from tumtools.cli import output
from tumtools.cli.complete import complete_places
from tumtools.cli.verbosity import offer, verbosity_options
from tumtools.errors import InternalError, OutputError, TumtoolsError, UsageError

COMMANDS: Final[dict[str, str]] = {
    "list": "List the sequences of the catalogue.",
    "fetch": "Download sequences, verify and unpack them.",
    "convert": "Convert a sequence to another format.",
    "info": "Show what a sequence holds.",
    "digest": "Print a content digest that does not depend on the format.",
    "diff": "Compare the contents of two sequences.",
    "validate": "Check sequences: files, stamps, images, depth, ground truth.",
    "rules": "List the rules of validate, or explain one.",
    "associate": "Pair two streams by their stamps.",
    "evaluate": "Measure an estimated trajectory against the ground truth.",
    "stats": "Print a sequence's motion, rates, drops and coverage.",
    "plot": "Draw trajectories and timelines.",
    "synth": "Make a synthetic sequence.",
    "batch": "Convert many sequences as a manifest says.",
    "cache": "Look after what has been fetched.",
    "formats": "List the formats and their options.",
    "completion": "Print a completion script for a shell.",
}
"""Each is a module of this package with an attribute `command`; here with its line of help, so that the
list of commands imports none of them."""

EXIT_INTERRUPTED: Final = 130
EXIT_BUG: Final = 70
_STDERR: Final = 2


class _LazyGroup(click.Group):
    """A group whose commands are imported when they are asked for."""

    def list_commands(self, ctx: click.Context) -> list[str]:
        """Return the names, in the order of the table."""
        del ctx
        return list(COMMANDS)

    def get_command(self, ctx: click.Context, cmd_name: str) -> click.Command | None:
        """Import a command."""
        del ctx
        if cmd_name not in COMMANDS:
            return None
        command = cast("click.Command", import_module(f"tumtools.cli.{cmd_name}").command)
        return complete_places(offer(command))

    def format_commands(self, ctx: click.Context, formatter: click.HelpFormatter) -> None:
        """List the commands without importing them."""
        del ctx
        with formatter.section("Commands"):
            formatter.write_dl(list(COMMANDS.items()))


@click.group(cls=_LazyGroup, context_settings={"help_option_names": ["-h", "--help"]})
@click.version_option(__version__, prog_name="tumtools", message="%(prog)s %(version)s")
def cli() -> None:
    """Get, check, convert, measure and re-export RGB-D sequences of the TUM RGB-D benchmark's layout.

    SOURCE is a path in any format, or the name of a sequence of the benchmark. -v and -q may stand before the
    command or behind it. Results go to stdout, everything else to stderr.
    """


cli.params.extend(verbosity_options())


def main(arguments: list[str] | None = None) -> NoReturn:
    """Run the program and exit with the code that its documentation promises."""
    signal.signal(signal.SIGTERM, _interrupt)
    _open_closed_streams()
    # File names may be in no known coding; they must not stop us from printing them.
    for stream in (sys.stdout, sys.stderr):
        if isinstance(stream, TextIOWrapper):
            stream.reconfigure(errors="backslashreplace")
    sys.exit(run(arguments))


def _open_closed_streams() -> None:
    """Open what was closed by `>&-`: nothing is printed then, and no other file may get its number."""
    while (descriptor := os.open(os.devnull, os.O_RDWR)) <= _STDERR:
        os.set_inheritable(descriptor, True)
    os.close(descriptor)
    # Python has None for a stream that is closed, whatever its types say.
    streams = {name: getattr(sys, name) for name in ("stdout", "stderr")}
    for name in (name for name, stream in streams.items() if stream is None):
        setattr(sys, name, Path(os.devnull).open("w"))  # noqa: SIM115 - for as long as the program runs


def run(arguments: list[str] | None = None) -> int:
    """Run the program and return its exit code."""
    output.verbosity = 0
    begin = perf_counter()
    try:
        code = cli.main(args=arguments, prog_name="tumtools", standalone_mode=False)
        sys.stdout.flush()
        if output.verbosity > 0:
            output.message(f"took {perf_counter() - begin:.2f} s")
    except click.ClickException as error:
        error.show()
        return UsageError.exit_code
    except TumtoolsError as error:
        return _report(error)
    except (KeyboardInterrupt, click.exceptions.Abort):  # click makes the second of the first
        return _report_interrupt()
    except (BrokenPipeError, SystemExit):  # click exits with 1 by itself when it cannot print; only then
        # The reader of a pipe has gone, as in `tumtools info x | head -1`.
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
        return 0
    except OSError as error:
        # Of the machine's making: no permission, a full disk, a device that fails.
        if output.verbosity > 1:
            output.traceback()
        name = error.filename if isinstance(error.filename, str) else os.fsdecode(error.filename or b"")
        output.error(f"{name}: {error.strerror or error}" if name else error.strerror or str(error))
        return OutputError.exit_code
    except Exception as error:  # noqa: BLE001 - whatever else comes here is a bug of ours
        return _report_interrupt() if _comes_of_interrupt(error) else _report_bug(error)
    return code if isinstance(code, int) else 0


def _report(error: TumtoolsError) -> int:
    if isinstance(error, InternalError) or output.verbosity > 1:
        output.traceback()
    output.error(str(error))
    return error.exit_code


def _report_interrupt() -> int:
    output.message("interrupted; nothing half-written was left behind")
    return EXIT_INTERRUPTED


def _comes_of_interrupt(error: BaseException | None) -> bool:
    """Tell whether an interrupt has become another error: Python does so while it makes a class."""
    while error is not None and not isinstance(error, KeyboardInterrupt):
        error = error.__cause__ or error.__context__
    return error is not None


def _report_bug(error: Exception) -> int:
    output.traceback()
    output.error(
        f"this is a bug of tumtools {__version__}: {type(error).__name__}: {error}\n  hint: please report it"
    )
    return EXIT_BUG


def _interrupt(number: int, frame: object) -> NoReturn:
    del number, frame
    raise KeyboardInterrupt
