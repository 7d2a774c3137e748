"""Write and check 1: write a small model and scene to begin with."""

import re
from pathlib import Path

from bgc.diagnostics.catalogue.reference import bad_new_name, file_exists
from bgc.grammar.language_words import RESERVED
from bgc.language.elements import ELEMENTS
from bgc.reference.library_entries import declarations
from bgc.runtime.cli.command import Target, argument, command, option, require
from bgc.runtime.cli.printing import print_text, write_file
from bgc.runtime.documents.templates import render_template

TEMPLATES = {
    "plain": "a mass on a spring and a damper",
    "mechanism": "a DC motor that turns a load through a gearbox",
    "crane": "a crane of library parts with a load",
}
_NAME = re.compile(r"[A-Za-z][A-Za-z0-9_]*")


@command()
def new(
    name: str = argument(),
    template: str = option(
        "; ".join(f"{name}: {text}" for name, text in TEMPLATES.items()) + ".",
        choices=TEMPLATES,
        default="plain",
        show_default=True,
    ),
) -> None:
    """Write NAME.bg: a small commented model and a scene that runs.

    NAME may begin with a folder that exists. A file is never replaced.
    """
    path = Path(name if name.endswith(".bg") else f"{name}.bg")
    is_name = _NAME.fullmatch(path.stem) and path.stem not in RESERVED
    require(is_name, bad_new_name(name, path.stem))
    Target(".bg").convert(str(path), None, None)  # refuses a folder that does not exist
    require(not path.exists(), file_exists(str(path)))
    text = render_template(
        f"{template}.bg.j2", model=_model_name(path.stem), scene=path.stem, file=path.name
    )
    write_file(path, text)
    steps = {
        f"bgc run {path} --plot {path.with_suffix('.png')}": "simulate it, draw the result",
        f"bgc causality {path}": "the causal strokes and their reasons",
        f"bgc doc {path}": "what the file declares",
        "bgc doc": "elements, words, functions, library parts",
    }
    width = max(map(len, steps))
    lines = (f"  {command:<{width}}  {purpose}" for command, purpose in steps.items())
    print_text("\n".join((f"{path}: {TEMPLATES[template]}", "next:", *lines)))


def _model_name(stem: str) -> str:
    """`pump_test` gives `PumpTest`; a name that is taken gets `Model` behind it."""
    name = "".join(part[:1].upper() + part[1:] for part in stem.split("_") if part)
    taken = name in ELEMENTS or any(d.name == name for d in declarations())
    return f"{name}Model" if taken else name
