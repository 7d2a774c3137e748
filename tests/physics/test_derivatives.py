"""f and its Jacobian in emitted C, on the library's scenes, against two independent answers.

Complex steps through the expressions (W. Squire, G. Trapp, SIAM Review 40, 1998), and central
differences.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Mapping
from functools import cache
from pathlib import Path

import numpy as np
import numpy.typing as npt
import pytest

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
# Values of a node: one for each state that is stepped, in one array.
Lanes = npt.NDArray[np.complex128]
ENTIRE: Mapping[Op, Callable[[Lanes], Lanes]] = {
    Op.SIN: np.sin, Op.COS: np.cos, Op.TAN: np.tan, Op.EXP: np.exp,
    Op.TANH: np.tanh, Op.SINH: np.sinh, Op.COSH: np.cosh, Op.ATAN: np.arctan,
    Op.ASIN: np.arcsin, Op.ACOS: np.arccos, Op.LOG: np.log, Op.SQRT: np.sqrt,
}  # fmt: skip
STEPS = {
    Op.SIGN, Op.FLOOR, Op.CEIL, Op.LT, Op.LE, Op.EQ, Op.AND, Op.OR, Op.NOT, Op.RANDOM,
}  # fmt: skip


def complex_values(op: Op, x: tuple[Lanes, ...]) -> Lanes:
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
            return np.where(a.real < 0, -a, a)
        case (Op.POW, (a, b)) if not b.imag.any() and b.real[0] == int(b.real[0]):
            # NumPy's complex powers go through the logarithm; products are exact near the axis.
            return np.array([y ** int(b.real[0]) for y in a.tolist()])
        case (Op.POW, (a, b)):
            return np.power(a, b)
        case (Op.HYPOT, (a, b)):
            return np.sqrt(a * a + b * b)
        case (Op.ATAN2, (y, x)):
            turn = (x.real * y.imag - y.real * x.imag) / (x.real**2 + y.real**2)
            return np.arctan2(y.real, x.real) + 1j * turn
        case (Op.SELECT, (condition, yes, no)):
            return np.where(condition.real != 0, yes, no)
        case (Op.MIN, (a, b)):
            return np.where(a.real <= b.real, a, b)
        case (Op.MAX, (a, b)):
            return np.where(a.real >= b.real, a, b)
        case _ if op in ENTIRE:
            return ENTIRE[op](x[0])
        case _:
            assert op in STEPS, op.name  # piecewise constant, of a real part that all share
            return np.full_like(x[0], apply(op, *(float(a.real[0]) for a in x)))


def looked_up(dag: Dag, node: int, operands: tuple[Lanes, ...]) -> Lanes:
    """A look-up in a table: the value there, and its slopes along the imaginary axis."""
    (one, two) = orders_of(int(operands[0].real[0]))
    table, x, y = dag.table_of(node), operands[1], operands[-1]
    at, beside = float(x.real[0]), float(y.real[0])
    if isinstance(table, Grid):
        value = table.value((one, two), at, beside)
        by_x, by_y = (table.value(o, at, beside) for o in ((one + 1, two), (one, two + 1)))
        return value + 1j * (by_x * x.imag + by_y * y.imag)
    match Op(dag.op[node]):
        case Op.PLACE:
            return np.full_like(x, table.place(at))
        case Op.PIECE:
            value, slope = (table.piece(one + k, at, int(beside)) for k in (0, 1))
        case _:
            value, slope = (table.value(one + k, at) for k in (0, 1))
    return value + 1j * slope * x.imag


def rates(program: Program, values: Mapping[Symbol, Lanes], lanes: int) -> Lanes:
    """The rates of all states: a row for each, a column for each lane."""
    dag: Dag = program.dag
    nodes = [state.derivative for state in program.states]
    done: dict[int, Lanes] = {}
    with np.errstate(all="ignore"):  # in the branches of a selection that are not taken
        for node in dag.reachable(nodes):
            exact, symbol = dag.value(node), dag.symbol_of(node)
            if exact is not None:
                done[node] = np.full(lanes, complex(to_double(exact)))
            elif symbol is not None:
                done[node] = np.broadcast_to(values[symbol], lanes)
            else:
                operands, op = tuple(done[x] for x in dag.operands(node)), Op(dag.op[node])
                looks_up = op in TABLE_OPS
                done[node] = (
                    looked_up(dag, node, operands) if looks_up else complex_values(op, operands)
                )
    return np.array([done[node] for node in nodes])


@cache
def compiled(path: Path, scene: str) -> tuple[Model, Program]:
    stages = compile_scene(path, Options(scene))
    return Model(stages.built), stages.optimised


def point(model: Model) -> Floats:
    """A state near the initial one, all moving and deflected: each state by a part of itself."""
    start = model.initial_state()
    shake = np.random.default_rng(7).uniform(-1, 1, len(start))
    return start + 0.05 * shake * np.maximum(np.abs(start), 1e-3)


@pytest.mark.parametrize(("path", "scene"), SCENES, ids=[name for _, name in SCENES])
def test_rates_and_jacobian_are_those_of_complex_steps(path: Path, scene: str) -> None:
    model, program = compiled(path, scene)
    state, time = point(model), 0.3
    values = {
        symbol: np.array(complex(value))
        for symbol, value in default_values(program.dag, program.parameters).items()
    }
    values[Symbol(Kind.TIME, 0)] = np.array(complex(time))
    values |= {Symbol(Kind.INPUT, k): np.array(0j) for k in range(program.inputs)}
    steps = 1j * TINY * np.eye(len(state))  # lane k steps state k
    values |= {Symbol(Kind.STATE, k): x + steps[k] for k, x in enumerate(state)}
    found = rates(program, values, len(state))
    exact = found[:, 0].real
    right = model.rhs(state, time)
    np.testing.assert_allclose(right, exact, rtol=1e-9, atol=1e-12 * np.abs(exact).max())
    jacobian, columns = model.jacobian(state, time), found.imag / TINY
    for k in range(len(state)):
        largest = np.abs(columns[:, k]).max(initial=0.0)
        np.testing.assert_allclose(jacobian[:, k], columns[:, k], rtol=1e-9, atol=1e-12 * largest)


@pytest.mark.parametrize(("path", "scene"), SCENES, ids=[name for _, name in SCENES])
def test_jacobian_is_that_of_central_differences(path: Path, scene: str) -> None:
    model, _ = compiled(path, scene)
    state, time = point(model), 0.3
    jacobian = model.jacobian(state, time)
    rates = model.rhs(state, time)
    # The noise of rates whose terms cancel, by changes of a few bits.
    signs = np.random.default_rng(8).choice([-1.0, 1.0], (6, len(state)))
    bits = 1e-15 * signs * np.maximum(np.abs(state), 1e-3)
    noise = np.max([np.abs(model.rhs(state + b, time) - rates) for b in bits], axis=0)

    def central(k: int, h: float) -> Floats:
        ahead, behind = (state + s * np.eye(len(state))[k] for s in (h, -h))
        return (model.rhs(ahead, time) - model.rhs(behind, time)) / (2 * h)

    for k, x in enumerate(state):
        column = np.abs(jacobian[:, k])
        h = 1e-4 * max(abs(x), 1e-3)
        difference = (4 * central(k, h) - central(k, 2 * h)) / 3
        error, rounding = np.abs(difference - jacobian[:, k]), 1e-14 * np.abs(rates) + noise
        assert (error <= 1e-6 * column + 1e-7 * column.max() + 10 * rounding / h).all()
