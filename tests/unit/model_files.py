"""The models of tests/models/unit: those that one file of unit tests needs."""

from pathlib import Path


def model_file(name: str) -> Path:
    return Path(__file__).parents[1] / "models" / "unit" / f"{name}.bg"


def model_text(name: str) -> str:
    return model_file(name).read_text("utf-8")
