"""Write and check 8: print the script for completion in bash, zsh or fish."""

import re
from pathlib import Path
from typing import Literal

import click
from click.shell_completion import CompletionItem, get_completion_class

from bgc.runtime.cli.command import argument, command

_SCENE = re.compile(r"^scene\s+(\w+)", re.MULTILINE)


@command()
def completion(shell: Literal["bash", "zsh", "fish"] = argument()) -> None:
    """Print the script by which a shell completes commands, options, methods and scenes.

    \b
    bash   eval "$(bgc completion bash)" in ~/.bashrc
    zsh    eval "$(bgc completion zsh)" in ~/.zshrc
    fish   bgc completion fish > ~/.config/fish/completions/bgc.fish
    """
    found = get_completion_class(shell)
    assert found is not None
    root = click.get_current_context().find_root().command
    click.echo(found(root, {}, "bgc", "_BGC_COMPLETE").source(), nl=False)


def scenes_of(
    context: click.Context, parameter: click.Parameter, begun: str
) -> list[CompletionItem]:
    """Complete the name of a scene from the text of the command's file, which is not compiled."""
    # Click leaves the arguments before an option that still lacks its value in `args`.
    words = [str(word) for word in (context.params.get("file"), *context.args) if word]
    try:
        text = Path(words[0]).read_text("utf-8") if words else ""
    except (OSError, UnicodeDecodeError):
        return []
    return [CompletionItem(name) for name in _SCENE.findall(text) if name.startswith(begun)]
