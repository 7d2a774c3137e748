"""The table of integration methods: the rows of C are written from it."""

from __future__ import annotations

import re
from pathlib import Path

import pytest
from method_rows import described, expected, rows

import bgc
from bgc.building.build import runtime_directory
from bgc.language.methods import METHODS, Method, default_method
from bgc.language.solver import SOLVER_OPTIONS, Solver

MODELS = Path(__file__).parents[1] / "models"
TABLE = runtime_directory() / "tableaus.c"
ROWS = re.compile(r"(?sm)(?<=const bgc_method bgc_methods\[\] = \{\n).*?(?=^\};)")


def test_the_rows_of_c_are_those_of_the_table(bless: bool) -> None:
    text = TABLE.read_text("utf-8")
    if bless:
        TABLE.write_text(ROWS.sub(lambda found: rows(), text), "utf-8")
        return
    found = ROWS.search(text)
    assert found is not None and found.group() == rows()


def test_the_interface_of_c_says_the_same() -> None:
    functions = bgc.compile(MODELS / "duffing.bg").library.functions
    assert described(functions) == [expected(method) for method in METHODS.values()]


def test_every_method_is_complete() -> None:
    assert len(METHODS) >= 12
    for method in METHODS.values():
        assert method.order > method.error_order >= 0
        assert 20 < len(method.purpose) < 80


def test_the_first_of_each_kind_is_the_default() -> None:
    assert default_method(fixed=False) == "rodas5p"
    assert default_method(fixed=True) == "ros34prw"


@pytest.mark.parametrize("method", METHODS.values(), ids=METHODS)
def test_its_options_are_those_of_a_solver_statement(method: Method) -> None:
    divided = Solver(method.name, substeps=2).served
    assert set(divided) <= set(SOLVER_OPTIONS)
    assert ("rtol" in divided) == (not method.fixed or method.embedded_order > 0)
    assert ("substeps" in divided) == (method.embedded_order > 0)
    assert ("keep" in divided) == (method.fixed and method.family.jacobian)
    assert ("rtol" in Solver(method.name, substeps=1).served) == (not method.fixed)
