"""The table of integration methods: one source, read from the text and through the interface."""

from __future__ import annotations

from pathlib import Path

import pytest

import bgc
from bgc.language.solver import SOLVER_OPTIONS
from bgc.runtime.running.methods import MethodInfo, default_method, known_methods

MODELS = Path(__file__).parents[1] / "models"
NAMES = [method.name for method in known_methods()]


def test_text_and_interface_agree() -> None:
    library = bgc.compile(MODELS / "duffing.bg").library
    assert list(library.methods.items()) == [(method.name, method) for method in known_methods()]


def test_every_method_is_complete() -> None:
    assert len(set(NAMES)) == len(NAMES) >= 12
    for method in known_methods():
        assert method.order > method.error_order >= 0
        assert method.family and 20 < len(method.purpose) < 80


def test_the_first_of_each_kind_is_the_default() -> None:
    assert default_method(known_methods(), fixed=False).name == "rodas5p"
    assert default_method(known_methods(), fixed=True).name == "ros34prw"


@pytest.mark.parametrize("method", known_methods(), ids=NAMES)
def test_its_options_are_those_of_a_solver_statement(method: MethodInfo) -> None:
    assert set(method.options) <= set(SOLVER_OPTIONS)
    assert ("rtol" in method.options) == (not method.fixed or method.embedded_order > 0)
    assert ("substeps" in method.options) == (method.embedded_order > 0)
    assert ("keep" in method.options) == (method.fixed and not method.explicit)
