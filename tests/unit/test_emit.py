"""The C of a model computes what the graph says, bit for bit where arithmetic allows."""

from __future__ import annotations

import os
import re
import subprocess
import sys
from dataclasses import replace
from fractions import Fraction
from pathlib import Path

import numpy as np
import pytest
from programs import RUNTIME, STRICT, CompiledModel, at, make_program, random_program, states

from bgc.algebra.dag import Dag, Kind, Op
from bgc.algebra.evaluate import evaluate_nodes
from bgc.emission.c_tables import quoted
from bgc.emission.emit import amalgamate, emit_model
from bgc.emission.print_c import literal
from bgc.emission.simplification import optimise

P = np.array([1.2, 0.7, 2.5])


@pytest.fixture(scope="module")
def random_model(tmp_path_factory: pytest.TempPathFactory):
    program = random_program(seed=1, size=12, operations=250)
    emitted = emit_model(optimise(program), "0")
    return program, CompiledModel(emitted, tmp_path_factory.mktemp("model"), P)


def points(size: int, count: int = 5):
    rng = np.random.default_rng(7)
    for _ in range(count):
        yield float(rng.normal()), rng.normal(size=size), rng.normal(size=1)


def test_kernels_agree_with_the_graph(random_model) -> None:
    program, model = random_model
    for t, x, u in points(12):
        values = at(x, t=t, p=P, u=u)
        for nodes, computed in (
            ([s.derivative for s in program.states], model.rhs(t, x, u)),
            ([o.node for o in program.observations], model.outputs(t, x, u)),
            ([g.condition for g in program.guards], model.asserts(t, x, u)),
            ([s.initial for s in program.states], model.initial(t, u)),
        ):
            expected = evaluate_nodes(program.dag, nodes, values)
            np.testing.assert_allclose(computed, expected, rtol=1e-11, atol=1e-12)
        np.testing.assert_array_equal(model.energy(t, x, u), [1, 2, 3])


def test_parameters_are_prepared_checked_and_defaulted(random_model) -> None:
    _, model = random_model
    assert model.checks() == pytest.approx([P[2] - P[0]])
    p = np.array([3.0, 4.0, -1.0])
    np.testing.assert_array_equal(model.defaults(p, [1, 1, 0]), [3, 4, 12])
    np.testing.assert_array_equal(model.defaults(p, [1, 1, 1]), p)


def test_long_code_of_parameters_is_a_table_of_operations(tmp_path: Path) -> None:
    """Outputs of parameters alone: choices, comparisons, constants, bare and equal parameters."""
    program = random_program(seed=3, size=12, operations=4_000)
    dag = program.dag
    p = np.random.default_rng(5).uniform(0.5, 1.5, 16)
    symbols = [dag.symbol(Kind.PARAM, k) for k in range(16)]
    fixed = {**dict(zip(states(dag, 12), symbols[4:], strict=True))}
    fixed |= {dag.symbol(Kind.TIME): symbols[3], dag.symbol(Kind.INPUT, 0): symbols[0]}
    nodes = [n for n in dag.reachable([o.node for o in program.observations]) if dag.op[n] > 1]
    outputs = [*dag.substitute(nodes[::40], fixed), symbols[1], symbols[1]]
    given = [(f"p{k}", dag.const(1)) for k in range(16)]
    (x,) = states(dag, 1)
    emitted = emit_model(make_program(dag, [x], parameters=given, outputs=outputs), "0")
    assert any("const int steps[]" in unit.text for unit in emitted.units)
    model = CompiledModel(emitted, tmp_path, p)
    for scale in (1.0, -0.3):
        model.set_parameters(scale * p)
        expected = evaluate_nodes(dag, outputs, at([1.0], p=scale * p))
        computed = model.outputs(0.0, np.ones(1), np.zeros(1))
        np.testing.assert_allclose(computed, expected, rtol=1e-11, atol=1e-12)


def test_projection_reads_all_states_before_it_writes_one(random_model) -> None:
    _, model = random_model
    x = np.arange(2.0, 14.0)
    np.testing.assert_array_equal(model.project(0.0, x), [6, 5, *x[2:]])


def slope(function, t: float, x: np.ndarray, u: np.ndarray, way, step: float = 2e-5):
    """The derivative of a function of t, x, u along `way` in (t, x), to order step^4."""

    def central(h: float):
        ahead, behind = ((t + s * way[0], x + s * way[1], u) for s in (h, -h))
        return (function(*ahead) - function(*behind)) / (2 * h)

    return (4 * central(step) - central(2 * step)) / 3


def test_jacobian_agrees_with_differences(random_model) -> None:
    _, model = random_model
    for t, x, u in points(12):
        jac, dfdt = model.entries(t, x, u)
        for unit, column in zip(np.eye(12), model.dense(jac).T, strict=True):
            by_state = slope(model.rhs, t, x, u, (0, unit))
            np.testing.assert_allclose(column, by_state, rtol=1e-6, atol=1e-8)
        by_time = slope(model.rhs, t, x, u, (1, 0))
        np.testing.assert_allclose(dfdt, by_time, rtol=1e-6, atol=1e-8)


@pytest.mark.parametrize("c", [0.5, 30.0, 1e5])
def test_solve_agrees_with_numpy(random_model, c: float) -> None:
    _, model = random_model
    t, x, u = next(points(12))
    jac, _ = model.entries(t, x, u)
    matrix = c * model.mass() - model.dense(jac)
    b = np.random.default_rng(3).normal(size=12)
    status, lu, growth = model.factor(jac, c)
    assert status == 0
    expected = np.linalg.solve(matrix, b)
    tolerance = 1e-14 * growth * np.linalg.cond(matrix)
    np.testing.assert_allclose(model.solve(lu, b), expected, rtol=tolerance, atol=tolerance)


def descriptor_program():
    """Two states and two algebraic ones, whose rows have no diagonal entry."""
    dag = Dag()
    x, y, a, b = states(dag, 4)
    p = dag.symbol(Kind.PARAM, 0)
    return make_program(
        dag,
        [b, dag.neg(a), dag.sub(b, dag.mul(x, y)), dag.sub(a, dag.add(x, p))],
        parameters=[("p", dag.const(2))],
        mass=[(0, 0, dag.one), (1, 1, p), (1, 0, dag.const(Fraction(1, 2)))],
    )


def test_algebraic_rows_are_solved_with_pivots_off_the_diagonal(tmp_path: Path) -> None:
    model = CompiledModel(emit_model(optimise(descriptor_program()), "0"), tmp_path, [2.0])
    x, u = np.array([1.0, 2.0, 3.0, 4.0]), np.zeros(1)
    np.testing.assert_array_equal(model.mass()[:2], [[1, 0, 0, 0], [0.5, 2, 0, 0]])
    jac, _ = model.entries(0.0, x, u)
    status, lu, _ = model.factor(jac, 10.0)
    assert status == 0
    matrix = 10.0 * model.mass() - model.dense(jac)
    b = np.array([1.0, -2.0, 3.0, -4.0])
    np.testing.assert_allclose(model.solve(lu, b), np.linalg.solve(matrix, b), rtol=1e-13)


def test_a_singular_matrix_is_a_status(tmp_path: Path) -> None:
    dag = Dag()
    x, y = states(dag, 2)
    program = make_program(dag, [dag.mul(dag.const(3), x), y])
    model = CompiledModel(emit_model(optimise(program), "0"), tmp_path)
    jac, _ = model.entries(0.0, np.ones(2), np.ones(1))
    assert model.factor(jac, 3.0)[0] == 1
    assert model.factor(jac, 4.0)[0] == 0
    assert model.factor(jac * np.nan, 4.0)[0] == 1


def test_growth_tells_a_cancelled_pivot(tmp_path: Path) -> None:
    dag = Dag()
    x, y = states(dag, 2)
    program = make_program(dag, [dag.mul(dag.const(3), x), y])
    model = CompiledModel(emit_model(optimise(program), "0"), tmp_path)
    jac, _ = model.entries(0.0, np.ones(2), np.ones(1))
    assert model.factor(jac, 100.0)[2] < 3
    assert model.factor(jac, 3.0 * (1 + 1e-9))[2] > 1e9


@pytest.mark.slow
def test_large_models_are_cut_into_functions(tmp_path: Path) -> None:
    program = random_program(seed=5, size=14, operations=700)
    emitted = emit_model(optimise(program), "0")
    names = [unit.name for unit in emitted.units if unit.name != "model_ranges"]
    assert names == ["model", "model_rates", "model_jacobian", "model_matrix"]
    model = CompiledModel(emitted, tmp_path, P)
    assert model.model.n_work > 0
    for t, x, u in points(14, 2):
        expected = evaluate_nodes(
            program.dag, [s.derivative for s in program.states], at(x, t=t, p=P, u=u)
        )
        np.testing.assert_allclose(model.rhs(t, x, u), expected, rtol=1e-10, atol=1e-11)
        matrix = model.dense(model.entries(t, x, u)[0])
        direction = np.random.default_rng(1).normal(size=14)
        along = slope(model.rhs, t, x, u, (0, direction), 1e-6)
        np.testing.assert_allclose(matrix @ direction, along, rtol=1e-5, atol=1e-6)


def test_an_edit_of_a_number_changes_the_unit_of_the_tables_alone() -> None:
    program = random_program(seed=5, size=14, operations=700)
    dag = program.dag
    first = program.parameters[0]
    edited = replace(
        program,
        parameters=(replace(first, value=dag.const(Fraction(7, 3))), *program.parameters[1:]),
        scene=replace(program.scene, step=Fraction(1, 8)),
    )
    before, after = (emit_model(optimise(each), str(k)) for k, each in enumerate((program, edited)))
    changed = [a.name for a, b in zip(before.units, after.units, strict=True) if a.text != b.text]
    assert changed == ["model"]


def test_a_model_of_nothing_compiles(tmp_path: Path) -> None:
    model = CompiledModel(emit_model(make_program(Dag(), []), "0"), tmp_path)
    assert model.model.n_state == 0
    assert model.factor(np.zeros(1), 1.0)[0] == 0


def test_names_with_quotes_and_trigraphs_are_kept(tmp_path: Path) -> None:
    dag = Dag()
    program = make_program(dag, [dag.zero], parameters=[('q"??=\\*/ß', dag.one)])
    CompiledModel(emit_model(program, "0"), tmp_path, [1.0])
    assert quoted('q"??=\\*/ß') == r'"q\"\?\?=\\*/\303\237"'


def test_emission_is_the_same_every_time() -> None:
    first, second = (
        emit_model(optimise(random_program(seed=2, size=8, operations=300)), "0") for _ in range(2)
    )
    assert [unit.text for unit in first.units] == [unit.text for unit in second.units]


@pytest.mark.parametrize(
    "value",
    [Fraction(1, 3), Fraction(10) ** 30, Fraction(1, 10**320), Fraction(-7), Fraction(1, 10)],
)
def test_literals_read_back_as_the_nearest_double(value: Fraction) -> None:
    assert float(literal(value)) == float(value)
    assert re.search(r"[.e]", literal(value))


def test_comparisons_and_choices_let_a_nan_through(tmp_path: Path) -> None:
    dag = Dag()
    x, y = states(dag, 2)
    nodes = [
        dag.call(Op.MIN, x, y),
        dag.call(Op.MAX, x, y),
        dag.call(Op.SIGN, x),
        dag.call(Op.LT, x, y),
        dag.select(dag.call(Op.AND, x, dag.call(Op.NOT, dag.call(Op.LE, x, y))), x, dag.neg(y)),
        dag.call(Op.OR, dag.call(Op.EQ, x, y), dag.call(Op.LT, y, x)),
    ]
    model = CompiledModel(emit_model(make_program(dag, [x, y], outputs=nodes), "0"), tmp_path)
    u, nan = np.zeros(1), np.nan
    np.testing.assert_array_equal(model.outputs(0.0, np.array([2.0, -3.0]), u), [-3, 2, 1, 0, 2, 1])
    for point in ([nan, 1.0], [1.0, nan]):
        values = model.outputs(0.0, np.array(point), u)
        np.testing.assert_array_equal(values, [nan, nan, np.sign(point[0]), nan, nan, nan])


def test_what_is_undefined_does_not_matter_where_another_condition_decides(tmp_path: Path) -> None:
    """A NaN in y, behind a guard on x; the printed C, and the evaluation in Python."""
    dag = Dag()
    x, y = states(dag, 2)
    guard, broken = dag.call(Op.LT, dag.zero, x), dag.call(Op.LT, dag.zero, y)
    closed = dag.call(Op.NOT, guard)
    chosen = dag.select(broken, dag.one, dag.const(2))
    nodes = [
        dag.call(Op.AND, guard, broken),
        dag.call(Op.AND, broken, guard),
        dag.call(Op.OR, closed, broken),
        dag.call(Op.NOT, broken),
        dag.select(guard, chosen, dag.const(3)),
        dag.select(dag.call(Op.AND, guard, broken), dag.one, dag.const(3)),
        dag.select(y, dag.one, dag.zero),
    ]
    model = CompiledModel(emit_model(make_program(dag, [x, y], outputs=nodes), "0"), tmp_path)
    nan = np.nan
    for point, expected in (
        ([-1.0, nan], [0, 0, 1, nan, 3, 3, nan]),
        ([1.0, nan], [nan, nan, nan, nan, nan, nan, nan]),
        ([1.0, -2.0], [0, 0, 0, 1, 2, 3, 1]),
        ([1.0, 2.0], [1, 1, 1, 0, 1, 1, 1]),
    ):
        np.testing.assert_array_equal(model.outputs(0.0, np.array(point), np.zeros(1)), expected)
        in_python = evaluate_nodes(dag, nodes, at(point))
        np.testing.assert_array_equal(in_python, expected)


@pytest.mark.parametrize("operations", [100, 700])
@pytest.mark.slow
def test_the_amalgamation_is_one_strict_c11_file(operations: int, tmp_path: Path) -> None:
    emitted = emit_model(optimise(random_program(seed=5, size=10, operations=operations)), "0")
    text = amalgamate(emitted, RUNTIME)
    assert '#include "' not in text
    (tmp_path / "whole.c").write_text(text, encoding="utf-8")
    command = ["cc", "-std=c11", "-O0", "-fPIC", *STRICT, "-shared", "whole.c", "-o", "whole.so"]
    subprocess.run([*command, "-lm"], cwd=tmp_path, check=True)


@pytest.mark.parametrize("large", [False, True])
def test_a_chain_of_masses_is_lowered_in_linear_time(large: bool, tmp_path: Path) -> None:
    """500 masses between springs; a dense step anywhere would take minutes."""
    count = 500 if large else 4
    dag = Dag()
    x = states(dag, 2 * count)
    k = dag.symbol(Kind.PARAM, 0)
    force = [dag.mul(k, dag.sub(x[i + 1], x[i])) for i in range(count - 1)]
    force = [dag.zero, *force, dag.zero]
    derivatives = [*x[count:], *(dag.sub(force[i + 1], force[i]) for i in range(count))]
    emitted = emit_model(optimise(make_program(dag, derivatives, parameters=[("k", dag.one)])), "0")
    operations = dict(emitted.operations)
    assert operations["rhs"] <= 3 * count
    assert operations["factor"] <= 40 * count
    assert emitted.lowered.plan.entries <= 10 * count


@pytest.mark.parametrize("name", ["plain", "descriptor"])
def test_tables_give_the_factors_where_nothing_is_unrolled(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, name: str
) -> None:
    program = {
        "plain": random_program(seed=1, size=12, operations=300),
        "descriptor": descriptor_program(),
    }[name]
    monkeypatch.setattr("bgc.emission.print_lu.UNROLLED", 0)
    model = CompiledModel(emit_model(optimise(program), "0"), tmp_path, P)
    n = model.model.n_state
    jac, _ = model.entries(0.3, np.linspace(0.1, 1.0, n), np.zeros(1))
    b = np.cos(np.arange(n))
    for c in (7.0, 7.0 - 2.0j):
        matrix = c * model.mass() - model.dense(jac)
        found = model.solve_by_tables(jac, c, b)
        np.testing.assert_allclose(found, np.linalg.solve(matrix, b), rtol=1e-11)


def test_initial_values_cannot_read_states() -> None:
    dag = Dag()
    (x,) = states(dag, 1)
    with pytest.raises(AssertionError, match="initial reads"):
        emit_model(make_program(dag, [x], initial=[x]), "0")


@pytest.mark.slow
def test_the_text_does_not_depend_on_the_order_of_hashes() -> None:
    program = (
        "import sys; from pathlib import Path; from bgc.driver import compile_scene;"
        "from bgc.options import Options;"
        "units = compile_scene(Path(sys.argv[1]), Options(), until='emit').emitted.units;"
        "print(*(unit.text for unit in units))"
    )
    scene = Path(__file__).parents[2] / "library" / "scenes" / "planar_crane.bg"
    texts = {
        subprocess.run(
            [sys.executable, "-c", program, str(scene)],
            env={**os.environ, "PYTHONHASHSEED": seed},
            capture_output=True,
            text=True,
            check=True,
        ).stdout
        for seed in ("1", "2")
    }
    assert len(texts) == 1
    assert "model_jacobian" in texts.pop()


def test_stores_of_known_values_are_loops_and_functions_of_bounded_length() -> None:
    """A chain's Jacobian of constants, equal ones side by side and others."""
    count = 1_000
    dag = Dag()
    x = states(dag, count)
    derivatives = [dag.mul(dag.const(2 if k < 100 else k), x[k]) for k in range(count)]
    units = emit_model(optimise(make_program(dag, derivatives)), "0").units
    (text,) = (unit.text for unit in units if "dfdt[k] = 0.0;" in unit.text)
    assert f"for (int k = 0; k < {count}; k++) dfdt[k] = 0.0;" in text
    assert "for (int k = 0; k < 100; k++) jac[k] = 2.0;" in text
    assert text.count("jac[") > 500
    functions = [part for part in text.split("\n}\n") if "jac[" in part]
    assert len(functions) > 3
    assert max(part.count(";") for part in functions) < 250
