"""The cell magic `%%bgc` of IPython and Jupyter, after `%load_ext bgc`."""

from __future__ import annotations

import re
import shlex
import tempfile
from collections.abc import Callable
from pathlib import Path
from typing import Any

from bgc.diagnostics.catalogue.arguments import bad_magic
from bgc.diagnostics.diagnostic import BgError
from bgc.diagnostics.public import public_function
from bgc.runtime.compiling import compile_model
from bgc.runtime.model import Model

_NAME = re.compile(r"[A-Za-z_]\w*")


def make_magic(variables: dict[str, Any]) -> Callable[[str, str], Model]:
    """Make the magic that binds models in a dictionary of variables."""
    folder = tempfile.TemporaryDirectory(prefix="bgc-")

    @public_function
    def bgc(line: str, cell: str) -> Model:
        """Compile the cell, and bind the model to a variable.

        `%%bgc NAME [SCENE] [--file FILE]`: FILE keeps the text, beside the files that it imports
        or the data that it reads. Without it the text is in a folder that goes with the session.
        """
        name, scene, kept = _arguments(line)
        path = Path(kept) if kept else Path(folder.name) / f"{name}.bg"
        path.write_text(cell, encoding="utf-8")
        variables[name] = model = compile_model(path, scene)
        return model

    return bgc


def _arguments(line: str) -> tuple[str, str | None, str | None]:
    """Read the line of the magic: the variable, the scene and the file."""
    try:
        words = shlex.split(line)
    except ValueError:
        raise BgError([bad_magic(line)]) from None
    kept = None
    if "--file" in words:
        at = words.index("--file")
        kept = words[at + 1] if at + 1 < len(words) else ""
        del words[at : at + 2]
    if not 1 <= len(words) <= 2 or not _NAME.fullmatch(words[0]) or kept == "":
        raise BgError([bad_magic(line)])
    return words[0], words[1] if len(words) > 1 else None, kept


def load_ipython_extension(ipython: Any) -> None:
    """Register `%%bgc`; IPython calls it for `%load_ext bgc`."""
    ipython.register_magic_function(make_magic(ipython.user_ns), "cell", "bgc")
