"""Models for the checks against independent answers, compiled once for all tests."""

from __future__ import annotations

from collections.abc import Callable
from functools import cache
from pathlib import Path

import pytest

import bgc
from bgc.runtime.model import Model

TESTS = Path(__file__).parents[1]


@cache
def compiled(name: str, scene: str | None) -> Model:
    return bgc.compile(TESTS / "models" / f"{name}.bg", scene=scene)


@pytest.fixture(scope="session")
def load() -> Callable[[str, str | None], Model]:
    """`load("tumbling", "euler")` gives that scene of tests/models/tumbling.bg, compiled."""
    return compiled
