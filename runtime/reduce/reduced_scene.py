"""The reduced scene as text: it extends the original, and carries the proof."""

from __future__ import annotations

import os
import re
import textwrap
from collections.abc import Sequence
from pathlib import Path

from bgc.elaboration.scenes.variants import Change
from bgc.record_class import dataclass

_WIDTH = 96
_NO_NAME = re.compile(r"\W")


@dataclass(frozen=True, slots=True)
class ReducedScene:
    """A scene that extends another by changed lines and a method.

    `path` is the file of the original, `base` its name, `digest` that of the original, `given` are
    changes that the user made to it, `changes` those of the study, and `proof` says what was run.
    """

    path: Path
    base: str
    digest: str
    given: tuple[Change, ...]
    changes: tuple[Change, ...]
    solver: str
    proof: str

    @property
    def name(self) -> str:
        """The name of the scene."""
        return f"{_NO_NAME.sub('_', self.base)}_reduced"

    def text(self) -> str:
        """The scene, to be put into the file of the original."""
        lines = [f"/// {line}" for line in textwrap.wrap(self.proof, _WIDTH)]
        lines.append(f"scene {self.name} is {self.base} {{")
        lines += [f"  {change.statement}" for change in (*self.given, *self.changes)]
        lines += [f"  {self.solver}", f'  proof "{self.digest}";', "}"]
        return "\n".join(lines) + "\n"

    def file(self, folder: Path) -> str:
        """The scene as a file of its own in a folder, which imports that of the original."""
        original = os.path.relpath(self.path.absolute(), folder.absolute())
        return f'import "{Path(original).as_posix()}";\n\n{self.text()}'


def statements(changes: Sequence[Change]) -> str:
    """Write changes in one line."""
    return " ".join(change.statement for change in changes)
