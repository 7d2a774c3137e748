"""The models that a campaign mutates: all `.bg` files of the repository and the manual's blocks."""

from __future__ import annotations

import re
from dataclasses import dataclass
from pathlib import Path

ROOT = Path(__file__).parents[2]
FOLDERS = ("library", "tests/models", "tests/golden", "tests/wrong")
# The scene of rigid legs takes longer than the limit of a mutant by itself.
TOO_SLOW = ("stewart.bg",)

_BLOCK = re.compile(r"^```bg([^\n]*)\n(.*?)^```$", re.MULTILINE | re.DOTALL)
_LARGE = 300  # characters: files of this size are drawn half as often as empty ones
_SHARE_OF_WRONG = 0.25  # of a file that is refused as it stands
_SHARE_OF_CRANES = 0.25  # of a file that takes ten times as long as others of its size


@dataclass(frozen=True, slots=True)
class Entry:
    """A text to mutate, the folder that its imports are relative to, and its name in reports."""

    name: str
    text: str
    folder: Path

    @property
    def weight(self) -> float:
        """Weight in drawing: small files are quicker to answer, right ones go further."""
        share = _SHARE_OF_WRONG if "wrong/" in self.name else 1.0
        share *= _SHARE_OF_CRANES if "import crane" in self.text else 1.0
        return share / (_LARGE + len(self.text))


def corpus() -> tuple[Entry, ...]:
    """All texts, sorted by name."""
    entries = []
    for folder in FOLDERS:
        for path in sorted((ROOT / folder).rglob("*.bg")):
            if path.name not in TOO_SLOW:
                text = path.read_text("utf-8", errors="surrogateescape")
                entries.append(Entry(str(path.relative_to(ROOT)), text, path.parent))
    for chapter in sorted((ROOT / "grammar" / "manual").rglob("*.md")):
        text = chapter.read_text("utf-8")
        for found in _BLOCK.finditer(text):
            name = f"{chapter.relative_to(ROOT)}:{text.count(chr(10), 0, found.start()) + 1}"
            body = found[2]
            if "model" in found[1].split():
                body = f"model Fragment {{\n{body}}}\n"
            entries.append(Entry(name, body, ROOT / "tests" / "models"))
    return tuple(entries)
