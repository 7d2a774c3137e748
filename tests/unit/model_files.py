"""Models of tests: those of tests/models/unit, which one file of tests needs, and texts."""

from pathlib import Path
from typing import Any

import bgc


def model_file(name: str) -> Path:
    return Path(__file__).parents[1] / "models" / "unit" / f"{name}.bg"


def model_text(name: str) -> str:
    return model_file(name).read_text("utf-8")


def compiled(folder: Path, text: str, **options: Any) -> bgc.Model:
    """The model of a text, compiled in a folder."""
    path = folder / "m.bg"
    path.write_text(text, encoding="utf-8")
    return bgc.compile(path, **options)
