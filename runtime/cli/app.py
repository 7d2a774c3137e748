"""The group of commands; errors become messages and exit statuses."""

from __future__ import annotations

import os
import re
import sys
import traceback
from collections.abc import Iterable
from contextlib import suppress
from importlib import import_module
from keyword import iskeyword
from pathlib import Path
from typing import Any, NoReturn

import click
from click.shell_completion import CompletionItem

from bgc.diagnostics.diagnostic import BgError, Diagnostic
from bgc.runtime.cli.signals import Caught
from bgc.runtime.cli.streams import discard_output

DONE, AT_FAULT, USAGE, BUG, INTERRUPTED = 0, 1, 2, 70, 130

_NOT_UTF8 = re.compile("[\udc80-\udcff]")  # surrogates for bytes of file names

# Each command is a module of this package, imported when it is named. So the modules import at
# their top what they need, and `bgc run` does not wait for what `bgc trade` imports.
GROUPS = {
    "Write and check": {
        "new": "write a small model and scene to begin with",
        "check": "report errors and warnings without compiling",
        "import": "write a robot (URDF, MJCF) or another tool's model as a .bg file",
        "fmt": "rewrite files in canonical form",
        "doc": "look up elements, functions, library parts, diagnostics ..",
        "explain": "look up a diagnostic (the same as doc)",
        "doctor": "check compiler, cache and packages of this machine",
        "completion": "print the script for completion in bash, zsh or fish",
        "lsp": "serve an editor: diagnostics, completion, hover, hints, names",
    },
    "Run": {
        "run": "simulate a scene, write and draw the result",
        "view": "show a scene in the browser, live, or a recorded run",
        "haptic": "run a scene in real time with its devices",
        "sweep": "simulate a scene for many values of its parameters",
        "fit": "estimate parameters from a recorded motion",
        "optimise": "find the parameters that make an observable least or largest",
        "operability": "find the sea states in which criteria hold, and the downtime",
        "devices": "list drivers and haptic devices, and why one cannot be used",
        "build": "compile a scene to C, to a shared object or to an FMU",
    },
    "Understand": {
        "causality": "show causal strokes with their reasons, storage, loops",
        "equations": "print the state equations, or their linear form and modes",
        "graph": "draw the bond graph with its causal strokes",
        "show": "print the result of one pass of the compiler",
    },
    "Linear models": {
        "modes": "print the modes: periods, damping, participating states",
        "poles": "print and draw poles and zeros",
        "bode": "compute and draw frequency responses",
        "margins": "print stability margins, draw Nyquist and Nichols charts",
        "step": "compute and draw a step response of the linear model",
        "locus": "follow the poles of a closed loop over its gain",
    },
    "Measure": {
        "cost": "show what a scene costs, what was left out, what variants cost",
        "trade": "measure speed against accuracy, and recommend a method",
        "stress": "drive a scene to its extremes, and map where it fails",
        "activity": "show where the energy goes, and what could be left out",
    },
}
COMMANDS = {name: text for group in GROUPS.values() for name, text in group.items()}


class Application(click.Group):
    """Loads commands when they are named, and turns errors into messages and statuses."""

    def list_commands(self, ctx: click.Context) -> list[str]:
        """Names of the commands, group by group."""
        return list(COMMANDS)

    def get_command(self, ctx: click.Context, cmd_name: str) -> click.Command | None:
        """Load a command."""
        if cmd_name not in COMMANDS:
            return None
        name = f"{cmd_name}_" if iskeyword(cmd_name) else cmd_name  # `import`
        command = getattr(import_module(f"bgc.runtime.cli.{name}"), name)
        assert isinstance(command, click.Command)
        return command

    def shell_complete(self, ctx: click.Context, incomplete: str) -> list[CompletionItem]:
        """Complete the names of commands and of own options, without loading the commands."""
        names = [
            CompletionItem(name, help=text)
            for name, text in COMMANDS.items()
            if name.startswith(incomplete)
        ]
        return [*names, *click.Command.shell_complete(self, ctx, incomplete)]

    def format_commands(self, ctx: click.Context, formatter: click.HelpFormatter) -> None:
        """List the commands in their groups, without loading them."""
        width = max(map(len, COMMANDS))
        for title, commands in GROUPS.items():
            with formatter.section(title):
                formatter.write_dl([(f"{name:<{width}}", text) for name, text in commands.items()])

    def main(self, *args: Any, obj: Caught | None = None, **extra: Any) -> NoReturn:
        """Run a command and exit with its status; `obj` notes signals."""
        extra["standalone_mode"] = False
        caught = obj or Caught()
        try:
            status = super().main(*args, **extra)
            sys.stdout.flush()  # a full disk is an error of the command
        except click.ClickException as problem:
            problem.show()
            status = problem.exit_code
        except click.Abort:
            status = INTERRUPTED
        except BgError as problem:
            print_diagnostics(problem.diagnostics)
            status = AT_FAULT
        except (OSError, MemoryError) as problem:
            discard_output()
            _show_traceback()
            print_diagnostics([_refused(problem)])
            status = AT_FAULT
        except Exception as problem:
            # An import that a signal interrupts may end in any error.
            status = INTERRUPTED if caught.number else _report_bug(problem)
        sys.exit(status or DONE)


@click.command(
    cls=Application,
    context_settings={"help_option_names": ["-h", "--help"]},
    invoke_without_command=True,
    no_args_is_help=True,
    subcommand_metavar="COMMAND [ARGS]...",
)
@click.option("--version", is_flag=True, help="Print the version.")
@click.option("--json", "as_json", is_flag=True, help="Print the version as JSON, with interfaces.")
@click.pass_context
def application(context: click.Context, version: bool, as_json: bool) -> None:
    """Compile bond graphs to C, and run them.

    FILE is a .bg file. `bgc COMMAND --help` describes a command, `bgc doc` the language.
    """
    if as_json and not version:
        raise click.UsageError("--json needs --version")
    if version:
        # Metadata of the installation takes 20 ms to import.
        from bgc.runtime.cli.version import version_text

        click.echo(version_text(as_json))
        context.exit()
    if context.invoked_subcommand is None:
        raise click.UsageError("Missing command.")


def print_diagnostics(diagnostics: Iterable[Diagnostic]) -> None:
    """Print diagnostics to standard error, in colour on a terminal."""
    diagnostics = tuple(diagnostics)
    if not diagnostics:
        return
    # `--help` and runs without warnings do without it.
    from bgc.diagnostics.render import render

    if text := render(diagnostics, colour=_colour_wanted()):
        with suppress(OSError):  # the terminal is closed: what follows may still write files
            click.echo(printable(text), err=True, nl=False)


def printable(text: str) -> str:
    r"""Show the bytes of a file's name that are not UTF-8 as `\xff`."""
    return _NOT_UTF8.sub(lambda found: f"\\x{ord(found[0]) - 0xDC00:02x}", text)


def _colour_wanted() -> bool:
    plain = "NO_COLOR" in os.environ or os.environ.get("TERM") == "dumb"
    return sys.stderr.isatty() and not plain


def _refused(problem: OSError | MemoryError) -> Diagnostic:
    """Say which service of the system failed, and for which file."""
    # A command that succeeds needs none of it.
    from bgc.diagnostics.catalogue.machine import system_refuses

    if isinstance(problem, MemoryError):
        return system_refuses("there is not enough memory", "")
    try:
        Path.cwd()
    except OSError:
        return system_refuses("the working directory no longer exists", "")
    return system_refuses(problem.strerror or str(problem), str(problem.filename or ""))


def _show_traceback() -> bool:
    """Print the traceback if BGC_DEBUG is set."""
    if os.environ.get("BGC_DEBUG"):
        traceback.print_exc()
        return True
    return False


def _report_bug(problem: Exception) -> int:
    """Report an error of bgc itself, with the traceback if BGC_DEBUG is set."""
    if not _show_traceback():
        kind = type(problem).__name__
        click.echo(printable(f"this is a bug in bgc: {kind}: {problem}"), err=True)
        click.echo(
            "please report it with the model and the output under BGC_DEBUG=1",
            err=True,
        )
    return BUG
