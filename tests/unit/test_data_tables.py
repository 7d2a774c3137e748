"""Tables of data: against SciPy, in Python and in C, with derivatives, segments and ranges."""

from __future__ import annotations

import itertools
import math
from collections.abc import Callable
from typing import Any

import numpy as np
import pytest
from programs import CompiledModel, at, make_program, states
from scipy.interpolate import (
    CubicSpline,
    PchipInterpolator,
    RectBivariateSpline,
    RegularGridInterpolator,
    interp1d,
)

from bgc.algebra.dag import Dag, Kind, Op
from bgc.algebra.derivatives import gradient
from bgc.algebra.discontinuities import jumps_in
from bgc.algebra.evaluate import evaluate_nodes
from bgc.algebra.fingerprint import Fingerprints
from bgc.algebra.table import Table
from bgc.diagnostics.source import Source, Span
from bgc.emission.emit import emit_model
from bgc.emission.lower import lower
from bgc.emission.simplification import optimise
from bgc.values.arithmetic import Operand
from bgc.values.interpolation import Known, interpolate, make_table
from bgc.values.value import Value

SPAN = Span(Source("<test>", ""), 0, 0)
METHODS = ("linear", "pchip", "spline", "nearest")
OUTSIDES = ("hold", "extrapolate", "repeat")
COUNTS = (2, 3, 4, 9, 700)


def known(values: Any, name: str = "v") -> Known:
    return Known(name, np.asarray(values, float), None, SPAN)


def data(count: int, seed: int, repeat: bool) -> tuple[np.ndarray, np.ndarray]:
    """Knots that are even for even seeds; values with plateaus, so that slopes vanish."""
    rng = np.random.default_rng(seed)
    x = np.arange(count) * 0.3 - 1 if seed % 2 == 0 else np.cumsum(rng.uniform(0.01, 3, count)) - 2
    y = np.round(rng.normal(size=count), 1)
    if repeat:
        y[-1] = y[0]
    return x, y


def reference(method: str, x: np.ndarray, y: np.ndarray, repeat: bool) -> Callable[..., Any]:
    """SciPy's function of an argument within the knots and the order of a derivative."""
    if method == "nearest":
        steps = interp1d(x, y, kind="nearest")
        return lambda at, order: steps(at) if order == 0 else np.zeros_like(at)
    if method == "linear":
        slopes = np.diff(y) / np.diff(x)
        place = lambda at: np.clip(np.searchsorted(x, at, side="right") - 1, 0, len(x) - 2)  # noqa: E731
        return lambda at, order: (np.interp(at, x, y), slopes[place(at)], np.zeros_like(at))[
            min(order, 2)
        ]
    if len(x) == 2:
        return reference("linear", x, y, repeat)
    if method == "pchip" and not repeat:
        made = PchipInterpolator(x, y)
    elif method == "pchip":  # three periods side by side have the slopes of the endless row
        period = x[-1] - x[0]
        long_x = np.concatenate((x[:-1] - period, x[:-1], x + period))
        made = PchipInterpolator(long_x, np.concatenate((y[:-1], y[:-1], y)))
    else:
        made = CubicSpline(x, y, bc_type="periodic" if repeat else "not-a-knot")
    return lambda at, order: made(at, order)


def expected(
    method: str, outside: str, x: np.ndarray, y: np.ndarray, at: np.ndarray, order: int
) -> np.ndarray:
    inside = reference(method, x, y, outside == "repeat")
    if outside == "repeat":
        return inside(x[0] + np.mod(at - x[0], x[-1] - x[0]), order)
    held = np.clip(at, x[0], x[-1])
    value = inside(held, order)
    if outside == "hold" or method == "nearest":
        return value if order == 0 else np.where(held == at, value, 0)
    slope = inside(held, 1)
    line = inside(held, 0) + slope * (at - held), slope, np.zeros_like(at)
    return np.where(held == at, value, line[min(order, 2)])


def arguments(x: np.ndarray, seed: int) -> np.ndarray:
    """Inside and outside, not at the knots and halfway between, where derivatives jump."""
    span = x[-1] - x[0]
    return np.random.default_rng(seed + 100).uniform(x[0] - 2.1 * span, x[-1] + 2.1 * span, 60)


CASES = [(m, o, n, s) for m, o, n in itertools.product(METHODS, OUTSIDES, COUNTS) for s in (0, 1)]
CASES = [case for case in CASES if not (case[1] == "repeat" and case[2] == 2)]


def table_of(method: str, outside: str, count: int, seed: int) -> Table:
    x, y = data(count, seed, outside == "repeat")
    return make_table(known(x), known(y), {"method": method, "outside": outside})


@pytest.mark.parametrize("method", METHODS)
@pytest.mark.parametrize("outside", OUTSIDES)
def test_values_and_derivatives_are_those_of_scipy(method: str, outside: str) -> None:
    for _, _, count, seed in (c for c in CASES if c[:2] == (method, outside)):
        x, y = data(count, seed, outside == "repeat")
        table = table_of(method, outside, count, seed)
        places = arguments(x, seed)
        for order in range(4):
            found = [table.value(order, float(p)) for p in places]
            wanted = expected(method, outside, x, y, places, order)
            scale = max(1.0, np.abs(wanted).max())
            tolerance = 1e-12 if outside != "repeat" else 1e-10  # whole periods are taken off
            np.testing.assert_allclose(found, wanted, rtol=tolerance, atol=tolerance * scale)


@pytest.mark.parametrize("case", [case for case in CASES if not table_of(*case).smooth], ids=str)
def test_segments_are_pieces_of_the_function(case: tuple[str, str, int, int]) -> None:
    """The place rises and is continuous, and on its segment the piece is the function."""
    table = table_of(*case)
    x = data(case[2], case[3], case[1] == "repeat")[0]
    rows = np.sort(np.concatenate((arguments(x, 3), x, 0.5 * (x[1:] + x[:-1]))))
    places = [table.place(float(p)) for p in rows]
    assert all(b >= a for a, b in itertools.pairwise(places))
    for p, place in zip(rows, places, strict=True):
        for order in (0, 1):
            held = table.piece(order, float(p), math.floor(place))
            tolerance = 0 if case[1] != "repeat" else 1e-9
            assert held == pytest.approx(table.value(order, float(p)), abs=tolerance) or (
                order == 1 and np.abs(np.mod(p - x[0], x[-1] - x[0]) - (x - x[0])).min() < 1e-9
            )
        near = table.place(float(np.nextafter(p, math.inf)))
        assert near - place <= 1e-9 * max(1, abs(place))


def test_breaks_are_where_the_function_is_not_smooth() -> None:
    def breaks(y: list[float], **options: str) -> list[int] | None:
        chosen = {"method": "linear", "outside": "hold"} | options
        table = make_table(known(range(len(y))), known(y), chosen)
        return None if table.breaks is None else list(table.breaks)

    assert breaks([0, 1, 2, 3, 0]) == [0, 3, 4]  # 1 and 2 lie on a line, the ends stop
    assert breaks([0, 1, 2, 3, 0], outside="extrapolate") == [3]
    assert breaks([0, 0, 1, 0, 0]) == [1, 2, 3]
    assert breaks([1, 1, 2, 2, 1], method="nearest") == [1, 3]
    assert breaks([0, 1, 0, 1, 0], method="pchip", outside="extrapolate") == []
    assert breaks([0, 1, 4, 9], method="spline") == [3]  # the slope at 0 is 0
    assert breaks([0, 2, 1]) is None


# --- two arguments ------------------------------------------------------------------------------


def surface(
    dag: Dag, options: dict[str, str], shape: tuple[int, int], seed: int
) -> tuple[Any, ...]:
    rng = np.random.default_rng(seed)
    x, y = (np.cumsum(rng.uniform(0.1, 2, n)) for n in shape)
    z = rng.normal(size=shape)
    if options["outside"] == "repeat":
        z[-1], z[:, -1] = z[0], z[:, 0]
    symbols = states(dag, 2)
    operands = [Operand(Value.scalar(s), SPAN) for s in symbols]
    value = interpolate(dag, [known(x), known(y), known(z)], operands, options, SPAN)
    return x, y, z, symbols, value.node


@pytest.mark.parametrize(
    ("method", "shape"),
    [
        *itertools.product(("linear", "nearest", "spline"), [(4, 5), (7, 4)]),
        *itertools.product(("linear", "nearest"), [(2, 3)]),  # splines need four knots
    ],
)
def test_surfaces_are_those_of_scipy(method: str, shape: tuple[int, int]) -> None:
    dag = Dag()
    x, y, z, symbols, node = surface(dag, {"method": method, "outside": "hold"}, shape, 3)
    slopes = gradient(dag, node, symbols)
    rng = np.random.default_rng(7)
    points = np.stack([rng.uniform(k[0], k[-1], 50) for k in (x, y)], axis=1)
    if method == "spline":
        spline = RectBivariateSpline(x, y, z)
        wanted = [spline.ev(*points.T, *orders) for orders in ((0, 0), (1, 0), (0, 1))]
    else:
        grid = RegularGridInterpolator((x, y), z, method)
        step = 1e-5
        differences = [(grid(points + d) - grid(points - d)) / (2 * step) for d in np.eye(2) * step]
        wanted = [grid(points), *differences]
    found = np.array([evaluate_nodes(dag, [node, *slopes], at(p)) for p in points]).T
    np.testing.assert_allclose(found[0], wanted[0], rtol=1e-12, atol=1e-12)
    tolerance = 1e-11 if method == "spline" else 1e-6
    np.testing.assert_allclose(found[1:], wanted[1:], rtol=tolerance, atol=10 * tolerance)


def test_surfaces_continue_outside() -> None:
    for method, outside in itertools.product(("linear", "spline"), OUTSIDES):
        dag = Dag()
        x, y, _, _, node = surface(dag, {"method": method, "outside": outside}, (6, 5), 4)

        def value(u: float, v: float, dag: Dag = dag, node: int = node) -> float:
            return evaluate_nodes(dag, [node], at([u, v]))[0]

        for u, v in ((x[0] - 1.3, y[2] + 0.01), (x[-1] + 0.7, y[-1] + 2), (x[1], y[0] - 9)):
            if outside == "hold":
                wanted = value(np.clip(u, x[0], x[-1]), np.clip(v, y[0], y[-1]))
            elif outside == "repeat":
                wanted = value(
                    x[0] + np.mod(u - x[0], x[-1] - x[0]), y[0] + np.mod(v - y[0], y[-1] - y[0])
                )
            else:  # a straight line in each argument
                step = 0.1 if u < x[0] or u > x[-1] else 0.0
                wanted = (value(u + step, v) + value(u - step, v)) / 2
            assert value(u, v) == pytest.approx(wanted, rel=1e-12, abs=1e-12)


# --- C ------------------------------------------------------------------------------------------


@pytest.mark.slow
def test_c_computes_what_python_computes(tmp_path) -> None:
    dag = Dag()
    x, y = states(dag, 2)
    outputs: list[int] = []
    for case in CASES:
        node = dag.look_up(table_of(*case), x)
        (slope,) = gradient(dag, node, [x])
        outputs += [node, slope]
    for method, outside in itertools.product(("linear", "nearest", "spline"), OUTSIDES):
        *_, node = surface(dag, {"method": method, "outside": outside}, (5, 6), 9)
        outputs += [node, *gradient(dag, node, [x, y])]
    table = table_of("linear", "hold", 9, 1)
    outputs += [dag.call(Op.PLACE, dag.const(table.number), x)]
    dag.tables.setdefault(table.number, table)
    program = optimise(make_program(dag, [dag.zero, dag.zero], outputs=outputs))
    model = CompiledModel(emit_model(program, ""), tmp_path)
    rng = np.random.default_rng(2)
    for point in (*rng.uniform(-5, 30, (40, 2)), np.array([-2.0, math.nan])):
        found = model.outputs(0.0, point, np.zeros(0))
        wanted = evaluate_nodes(dag, outputs, at([float(p) for p in point]))
        np.testing.assert_allclose(found, wanted, rtol=1e-12, atol=1e-12)


@pytest.mark.slow
def test_ranges_contain_the_values_and_shrink(tmp_path) -> None:
    """Bounds of functions of time and of their slopes, over windows long and short."""
    dag = Dag()
    time = dag.symbol(Kind.TIME)
    nodes = [dag.look_up(table_of(*case), time) for case in CASES if case[2] in (4, 700)]
    for method in ("linear", "spline"):
        *_, symbols, node = surface(dag, {"method": method, "outside": "hold"}, (5, 6), 9)
        arguments = (time, dag.add(dag.one, time))
        nodes += dag.substitute([node], dict(zip(symbols, arguments, strict=True)))
    program = optimise(make_program(dag, [*nodes, *states(dag, 1)]))
    emitted = emit_model(program, "")
    model = CompiledModel(emitted, tmp_path)
    terms = emitted.lowered.ranges
    assert terms is not None
    graph, stores = emitted.lowered.program.dag, terms.stores
    rng = np.random.default_rng(1)
    mode = {s: math.nan for s in graph.symbols if s.kind is Kind.INPUT}
    for width in (1e-3, 0.5, 10.0, 300.0):
        low = float(rng.uniform(-3, 20))
        found = model.ranges(low, low + width).reshape(-1, 2)
        places = np.linspace(low, low + width, 60)
        values = np.array(
            [evaluate_nodes(graph, [s.node for s in stores], at([0.0], t=t) | mode) for t in places]
        )
        slack = 1e-9 * (1 + np.abs(values).max(0))
        assert np.all(found[:, 0] <= values.min(0) + slack)
        assert np.all(found[:, 1] >= values.max(0) - slack)
    narrow = model.ranges(3.0, 3.0 + 1e-9).reshape(-1, 2)
    assert np.all(narrow[:, 1] - narrow[:, 0] < 1e-6)


@pytest.mark.parametrize("method", ["linear", "nearest", "pchip"])
def test_knots_are_kinks_of_lines_and_jumps_of_steps(method: str) -> None:
    """A kink that does not matter may be passed over, a jump never; the ends of pchip are kinks."""
    dag = Dag()
    (x,) = states(dag, 1)
    node = dag.look_up(table_of(method, "hold", 9, 1), x)
    (switch,) = lower(optimise(make_program(dag, [node]))).switches
    assert switch.jumps == (method == "nearest")
    assert bool(jumps_in(dag, Fingerprints(dag), node)) == (method == "nearest")
    (slope,) = gradient(dag, node, [x])
    assert method == "nearest" or jumps_in(dag, Fingerprints(dag), slope)
