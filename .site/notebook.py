"""A page of the site made of a notebook, whose cells are run for what they show."""

from __future__ import annotations

import json
import re
from base64 import b64encode
from collections.abc import Iterator
from pathlib import Path
from typing import Any

from pages import Page

_BLANK = re.compile(r"\n\s*\n")


def notebook_page(path: str, source: str, file: Path) -> Page:
    """Run the cells of a notebook in order, and return them with their outputs.

    Of an output stands the first form that a page can show: HTML, SVG, PNG or text. A cell that
    fails raises its error.
    """
    # An optional package: `needs.py` says how to get it before this one is needed.
    from IPython.core.interactiveshell import InteractiveShell
    from IPython.utils.capture import capture_output

    cells = json.loads(file.read_text("utf-8"))["cells"]
    shell = InteractiveShell()
    shell.history_manager.enabled = False
    lines: list[str] = []
    for cell in cells:
        text = "".join(cell["source"])
        if cell["cell_type"] == "markdown":
            lines += [*text.splitlines(), ""]
            continue
        with capture_output():
            done = shell.run_cell(text)
        done.raise_error()
        language = "bg" if text.startswith("%%bgc") else "python"
        lines += [f"```{language}", *text.splitlines(), "```", ""]
        if done.result is not None:
            lines += [*_forms(shell.display_formatter.format(done.result)[0]), ""]
    title = next(line for line in lines if line.startswith("# "))
    return Page(path, title.removeprefix("# "), source, lines)


def _forms(data: dict[str, Any]) -> Iterator[str]:
    """Return the lines of an output; Markdown ends HTML at a blank line."""
    if "text/html" in data:
        yield f"<div>{_BLANK.sub(chr(10), data['text/html'])}</div>"
    elif "image/svg+xml" in data:
        svg = data["image/svg+xml"]
        yield f"<div>{_BLANK.sub(chr(10), svg[svg.index('<svg') :])}</div>"
    elif "image/png" in data:
        image = data["image/png"]
        code = image if isinstance(image, str) else b64encode(image).decode()
        yield f'<p><img alt="Output of the cell" src="data:image/png;base64,{code.strip()}"></p>'
    else:
        yield "```text"
        yield from data["text/plain"].splitlines()
        yield "```"
