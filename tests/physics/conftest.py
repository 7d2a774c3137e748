"""Models for the checks against independent answers, compiled once for all tests."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from functools import cache, partialmethod
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


@pytest.fixture(scope="module", autouse=True)
def errors_where_judged(request: pytest.FixtureRequest) -> Iterator[None]:
    """Estimate errors in modules marked `errors` alone: the rows are the same bits without."""
    with pytest.MonkeyPatch.context() as patch:
        if request.node.get_closest_marker("errors") is None:
            patch.setattr(Model, "simulate", partialmethod(Model.simulate, error=False))
        yield
