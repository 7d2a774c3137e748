"""The installation as a shell uses it: version, completion, manual page."""

import json
import re
import shutil
import subprocess
from importlib import metadata
from pathlib import Path

import click
import pytest
from click.testing import CliRunner

import bgc.runtime
from bgc.resolution.library import library_folder
from bgc.runtime.cli.app import application, command_groups
from bgc.runtime.documents.manual_page import manual_page
from bgc.runtime.running.structures import ABI

CRANE = library_folder() / "scenes" / "two_beam_crane.bg"
PAGE = Path(bgc.runtime.__path__[0]) / "documents" / "bgc.1"


def completed(*words: str) -> list[str]:
    """The words that bash is offered in place of the last one."""
    environment = {
        "_BGC_COMPLETE": "bash_complete",
        "COMP_WORDS": " ".join(("bgc", *words)),
        "COMP_CWORD": str(len(words)),
    }
    result = CliRunner().invoke(application, [], env=environment, prog_name="bgc")
    return [line.partition(",")[2] for line in result.stdout.splitlines() if line]


def test_the_version_for_people_and_for_programs():
    version = metadata.version("bgc-lang")
    assert CliRunner().invoke(application, ["--version"]).stdout == f"bgc, version {version}\n"
    facts = json.loads(CliRunner().invoke(application, ["--version", "--json"]).stdout)
    assert (facts["version"], facts["abi"]) == (version, ABI)
    assert set(facts) == {"version", "abi", "python", "platform"}
    alone = CliRunner().invoke(application, ["--json"])
    assert alone.exit_code == 2 and "--json needs --version" in alone.output


def test_a_shell_completes_commands_options_and_scenes():
    assert completed("") == application.list_commands(click.Context(application))
    assert completed("tr") == ["trade"]
    assert "--solver" in completed("run", "--s")
    assert completed("run", str(CRANE), "--scene", "e") == ["elevation_force"]
    assert completed("run", str(CRANE.with_name("none.bg")), "--scene", "e") == []


def test_every_command_is_listed_by_the_first_line_of_its_module():
    """A module whose first line has a wrong group or form would be no command."""
    folder = Path(bgc.runtime.__path__[0]) / "cli"
    texts = [path.read_text("utf-8") for path in folder.glob("*.py")]
    made = {found[1] for text in texts if (found := re.search(r"\n@command.*\ndef ([a-z]+)", text))}
    assert made == {name for commands in command_groups().values() for name in commands}


@pytest.mark.parametrize("shell", ["bash", "zsh", "fish"])
def test_the_script_of_a_shell_is_its_own_syntax(shell):
    script = CliRunner().invoke(application, ["completion", shell]).stdout
    assert f"_BGC_COMPLETE={shell}_complete" in script
    if path := shutil.which(shell):
        subprocess.run([path, "-n"], input=script, text=True, check=True)


def test_the_manual_page_is_that_of_the_commands(bless):
    text = manual_page(application, command_groups())
    if bless:
        PAGE.write_text(text, "utf-8")
    assert PAGE.read_text("utf-8") == text, "pytest tests/unit/test_shell.py --bless writes it"
    for name in application.list_commands(click.Context(application)):
        assert f'.SH "bgc {name}"' in text


@pytest.mark.skipif(shutil.which("groff") is None, reason="needs groff")
def test_the_manual_page_has_no_fault_of_its_markup():
    command = ["groff", "-man", "-Tutf8", "-ww", "-z"]
    done = subprocess.run(
        command, input=PAGE.read_bytes(), capture_output=True, check=True, timeout=60
    )
    assert done.stderr == b""


def test_help_fits_a_terminal_of_80_columns():
    """Click wraps what it formats; examples and tables are printed as they are."""
    for name in application.list_commands(click.Context(application)):
        context = click.Context(application, info_name="bgc")
        command = application.get_command(context, name)
        assert command is not None
        inner = click.Context(
            command, parent=context, info_name=name, terminal_width=80, max_content_width=80
        )
        wide = [line for line in command.get_help(inner).splitlines() if len(line) > 80]
        assert not wide, f"bgc {name} --help"
