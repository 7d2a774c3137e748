"""f and its Jacobian in emitted C, on the library's scenes, against two independent answers.

Complex steps through the expressions (W. Squire, G. Trapp, SIAM Review 40, 1998), and central
differences.
"""

from __future__ import annotations

import cmath
import math
import re
from collections.abc import Callable, Mapping
from functools import cache
from pathlib import Path

import numpy as np
import numpy.typing as npt
import pytest

import bgc
import bgc.library
from bgc.algebra.dag import TABLE_OPS, Dag, Kind, Op, Symbol
from bgc.algebra.evaluate import apply, to_double
from bgc.algebra.table import Grid, orders_of
from bgc.driver import compile_scene
from bgc.ir.defaults import default_values
from bgc.ir.program import Program
from bgc.options import Options
from bgc.runtime.model import Model

Floats = npt.NDArray[np.float64]

SCENES = [
    (path, name)
    for path in sorted((Path(bgc.library.__file__).parent / "scenes").glob("*.bg"))
    for name in re.findall(r"^scene (\w+)", path.read_text(), re.MULTILINE)
]
TINY = 1e-100  # no difference is taken, so nothing cancels
ENTIRE: Mapping[Op, Callable[[complex], complex]] = {
    Op.SIN: cmath.sin, Op.COS: cmath.cos, Op.TAN: cmath.tan, Op.EXP: cmath.exp,
    Op.TANH: cmath.tanh, Op.SINH: cmath.sinh, Op.COSH: cmath.cosh, Op.ATAN: cmath.atan,
    Op.ASIN: cmath.asin, Op.ACOS: cmath.acos, Op.LOG: cmath.log, Op.SQRT: cmath.sqrt,
}  # fmt: skip
STEPS = {
    Op.SIGN, Op.FLOOR, Op.CEIL, Op.LT, Op.LE, Op.EQ, Op.AND, Op.OR, Op.NOT, Op.RANDOM,
}  # fmt: skip


def complex_value(op: Op, x: tuple[complex, ...]) -> complex:
    """One operation on complex numbers close to the real axis."""
    match op, x:
        case (Op.ADD, (a, b)):
            return a + b
        case (Op.SUB, (a, b)):
            return a - b
        case (Op.MUL, (a, b)):
            return a * b
        case (Op.DIV, (a, b)):
            return a / b
        case (Op.NEG, (a,)):
            return -a
        case (Op.ABS, (a,)):
            return -a if a.real < 0 else a
        case (Op.POW, (a, b)) if b.imag == 0 and b.real == int(b.real):
            return a ** int(b.real)
        case (Op.POW, (a, b)):
            return a**b
        case (Op.HYPOT, (a, b)):
            return cmath.sqrt(a * a + b * b)
        case (Op.ATAN2, (y, x)):
            turn = (x.real * y.imag - y.real * x.imag) / (x.real**2 + y.real**2)
            return complex(math.atan2(y.real, x.real), turn)
        case (Op.SELECT, (condition, yes, no)):
            return yes if condition.real != 0 else no
        case (Op.MIN, (a, b)):
            return a if a.real <= b.real else b
        case (Op.MAX, (a, b)):
            return a if a.real >= b.real else b
        case _ if op in ENTIRE:
            return ENTIRE[op](x[0])
        case _:
            assert op in STEPS, op.name
            return complex(apply(op, *(a.real for a in x)))  # piecewise constant


def looked_up(dag: Dag, node: int, operands: tuple[complex, ...]) -> complex:
    """A look-up in a table: the value there, and its slopes along the imaginary axis."""
    table, (one, two) = dag.table_of(node), orders_of(int(operands[0].real))
    x, y = operands[1], operands[-1]
    if isinstance(table, Grid):
        value = table.value((one, two), x.real, y.real)
        by_x, by_y = (table.value(o, x.real, y.real) for o in ((one + 1, two), (one, two + 1)))
        return complex(value, by_x * x.imag + by_y * y.imag)
    match Op(dag.op[node]):
        case Op.PLACE:
            return complex(table.place(x.real))
        case Op.PIECE:
            value, slope = (table.piece(one + k, x.real, int(y.real)) for k in (0, 1))
        case _:
            value, slope = (table.value(one + k, x.real) for k in (0, 1))
    return complex(value, slope * x.imag)


def rates(program: Program, values: Mapping[Symbol, complex]) -> list[complex]:
    """The rates of all states."""
    dag: Dag = program.dag
    nodes = [state.derivative for state in program.states]
    done: dict[int, complex] = {}
    for node in dag.reachable(nodes):
        exact, symbol = dag.value(node), dag.symbol_of(node)
        if exact is not None:
            done[node] = complex(to_double(exact))
        elif symbol is not None:
            done[node] = complex(values[symbol])
        else:
            operands, op = tuple(done[x] for x in dag.operands(node)), Op(dag.op[node])
            looks_up = op in TABLE_OPS
            done[node] = looked_up(dag, node, operands) if looks_up else complex_value(op, operands)
    return [done[node] for node in nodes]


@cache
def compiled(path: Path, scene: str) -> tuple[Model, Program]:
    program = compile_scene(path, Options(scene), until="optimise").optimised
    return bgc.compile(path, scene=scene), program


def point(model: Model) -> Floats:
    """A state near the initial one, all moving and deflected: each state by a part of itself."""
    start = model.initial_state()
    shake = np.random.default_rng(7).uniform(-1, 1, len(start))
    return start + 0.05 * shake * np.maximum(np.abs(start), 1e-3)


@pytest.mark.parametrize(("path", "scene"), SCENES, ids=[name for _, name in SCENES])
def test_rates_and_jacobian_are_those_of_complex_steps(path: Path, scene: str) -> None:
    model, program = compiled(path, scene)
    state, time = point(model), 0.3
    values: dict[Symbol, complex] = dict(default_values(program.dag, program.parameters))
    values[Symbol(Kind.TIME, 0)] = time
    values.update({Symbol(Kind.INPUT, k): 0.0 for k in range(program.inputs)})
    values.update({Symbol(Kind.STATE, k): x for k, x in enumerate(state)})
    exact = np.array(rates(program, values)).real
    found = model.rhs(state, time)
    np.testing.assert_allclose(found, exact, rtol=1e-9, atol=1e-12 * np.abs(exact).max())
    jacobian = model.jacobian(state, time)
    for k, x in enumerate(state):
        stepped = rates(program, {**values, Symbol(Kind.STATE, k): x + 1j * TINY})
        column = np.array(stepped).imag / TINY
        largest = np.abs(column).max(initial=0.0)
        np.testing.assert_allclose(jacobian[:, k], column, rtol=1e-9, atol=1e-12 * largest)


@pytest.mark.parametrize(("path", "scene"), SCENES, ids=[name for _, name in SCENES])
def test_jacobian_is_that_of_central_differences(path: Path, scene: str) -> None:
    model, _ = compiled(path, scene)
    state, time = point(model), 0.3
    jacobian = model.jacobian(state, time)
    size = np.abs(model.rhs(state, time))

    def central(k: int, h: float) -> Floats:
        ahead, behind = (state + s * np.eye(len(state))[k] for s in (h, -h))
        return (model.rhs(ahead, time) - model.rhs(behind, time)) / (2 * h)

    for k, x in enumerate(state):
        h = 1e-4 * max(abs(x), 1e-3)
        difference = (4 * central(k, h) - central(k, 2 * h)) / 3
        rounding = 1e-14 * size / h
        largest = np.abs(jacobian[:, k]).max()
        error = np.abs(difference - jacobian[:, k])
        assert (error <= 1e-6 * np.abs(jacobian[:, k]) + 1e-7 * largest + 10 * rounding).all()
