"""The group of commands; errors become messages and exit statuses."""

import os
import re
import sys
from functools import cache
from importlib import import_module
from keyword import iskeyword
from pathlib import Path
from typing import Any, NoReturn

import click
from click.shell_completion import CompletionItem

from bgc.diagnostics.diagnostic import BgError, Diagnostic
from bgc.runtime.cli.printing import (
    AT_FAULT,
    BUG,
    DONE,
    INTERRUPTED,
    print_diagnostics,
    print_text,
)
from bgc.runtime.cli.signals import Caught
from bgc.runtime.cli.streams import discard_output

_FOLDER = Path(__file__).parent
TITLES = ("Write and check", "Run", "Understand", "Linear models", "Measure")
_FIRST_LINE = re.compile(r'"""(.+) (\d+): (.+)\."""')


@cache
def command_groups() -> dict[str, dict[str, str]]:
    """Texts of all commands by name, in titled groups; no command is loaded.

    A command is a module of this package whose first line says its group, its place in the group,
    and its text: `Run 1: simulate a scene.`. It is imported when it is named, so that it may
    import at its top what it needs: `bgc run` does not wait for what `bgc trade` imports.
    """
    found = {path.stem.rstrip("_"): _first_line(path) for path in _FOLDER.glob("*.py")}
    rows = sorted((int(line[2]), name, line) for name, line in found.items() if line)
    return {
        title: {name: line[3] for _, name, line in rows if line[1] == title} for title in TITLES
    }


def _first_line(path: Path) -> re.Match[str] | None:
    with path.open(encoding="utf-8") as file:
        return _FIRST_LINE.match(file.readline())


class Application(click.Group):
    """Loads commands when they are named, and turns errors into messages and statuses."""

    def list_commands(self, ctx: click.Context) -> list[str]:
        """Names of the commands, group by group."""
        return [name for commands in command_groups().values() for name in commands]

    def get_command(self, ctx: click.Context, cmd_name: str) -> click.Command | None:
        """Load a command."""
        name = f"{cmd_name}_" if iskeyword(cmd_name) else cmd_name  # `import`
        path = _FOLDER / f"{name}.py"
        if not (name.isidentifier() and path.exists() and _first_line(path)):
            return None
        command = getattr(import_module(f"bgc.runtime.cli.{name}"), name)
        assert isinstance(command, click.Command)
        return command

    def shell_complete(self, ctx: click.Context, incomplete: str) -> list[CompletionItem]:
        """Complete the names of commands and of own options, without loading the commands."""
        names = [
            CompletionItem(name, help=text)
            for commands in command_groups().values()
            for name, text in commands.items()
            if name.startswith(incomplete)
        ]
        return [*names, *click.Command.shell_complete(self, ctx, incomplete)]

    def format_commands(self, ctx: click.Context, formatter: click.HelpFormatter) -> None:
        """List the commands in their groups, without loading them."""
        width = max(map(len, self.list_commands(ctx)))
        for title, commands in command_groups().items():
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
            if os.environ.get("BGC_DEBUG"):
                sys.excepthook(type(problem), problem, problem.__traceback__)
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
        click.echo(_version(as_json))
        context.exit()
    if context.invoked_subcommand is None:
        raise click.UsageError("Missing command.")


def _version(as_json: bool) -> str:
    """Write `bgc, version 1.2.3`, or JSON for programs.

    The JSON object has `version`, that of the package; `abi`, the interface between compiled models
    and the runtime; `python` and `platform`.
    """
    # Metadata of the installation takes 20 ms to import.
    import json
    import platform
    from importlib import metadata

    from bgc.runtime.running.structures import ABI

    facts = {
        "version": metadata.version("bgc-lang"),
        "abi": ABI,
        "python": platform.python_version(),
        "platform": f"{platform.system().lower()}-{platform.machine().lower()}",
    }
    return json.dumps(facts) if as_json else f"bgc, version {facts['version']}"


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


def _report_bug(problem: Exception) -> int:
    """Report an error of bgc itself, with the traceback if BGC_DEBUG is set."""
    if os.environ.get("BGC_DEBUG"):
        sys.excepthook(type(problem), problem, problem.__traceback__)
    else:
        print_text(
            f"this is a bug in bgc: {type(problem).__name__}: {problem}\n"
            "please report it with the model and the output under BGC_DEBUG=1",
            err=True,
        )
    return BUG
