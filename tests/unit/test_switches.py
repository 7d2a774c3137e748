"""Operations that become modes, and the kernels that read them."""

from __future__ import annotations

import math
import random
from collections.abc import Sequence
from pathlib import Path

import numpy as np
import pytest
from programs import CompiledModel, at, make_program, states
from scipy.integrate import solve_ivp

import bgc
from bgc.algebra.dag import Dag, Kind, Op
from bgc.algebra.evaluate import evaluate_nodes
from bgc.algebra.operation import Jump
from bgc.diagnostics.source import Source, Span
from bgc.emission.emit import emit_model
from bgc.emission.lower import lower
from bgc.emission.simplification import optimise
from bgc.emission.switches import hold_modes
from bgc.ir.lowered import Switch


class Maker:
    """A program of one state x and the time, from a function of the graph."""

    def __init__(self) -> None:
        self.dag = Dag()
        (self.x,) = states(self.dag, 1)
        self.t = self.dag.symbol(Kind.TIME)
        self.p = self.dag.symbol(Kind.PARAM, 0)
        self.u = self.dag.symbol(Kind.INPUT, 0)

    def program(self, node: int, outputs: Sequence[int] = ()):
        parameters = [("p", self.dag.const(2))]
        return make_program(self.dag, [node], parameters=parameters, inputs=1, outputs=outputs)

    def switches(self, node: int) -> tuple[Switch, ...]:
        return hold_modes(self.program(node))[1]


@pytest.fixture
def make() -> Maker:
    return Maker()


@pytest.mark.parametrize("op", [Op.EQ, Op.TANH])
def test_smooth_operations_raise_no_events(make: Maker, op: Op) -> None:
    operands = (make.x,) if op == Op.TANH else (make.x, make.t)
    program = make.program(make.dag.call(op, *operands))
    held, switches = hold_modes(program)
    assert switches == ()
    assert held is program


def test_what_only_parameters_or_held_inputs_decide_raises_none(make: Maker) -> None:
    dag = make.dag
    for other in (make.p, make.u):
        condition = dag.call(Op.LT, other, dag.one)
        assert make.switches(dag.select(condition, make.x, dag.one)) == ()


@pytest.mark.parametrize(("of_time", "of_states"), [(1, 1), (1, 0), (0, 1)])
def test_switches_of_time_have_a_kernel_of_their_own_only_beside_others(
    make: Maker, of_time: int, of_states: int
) -> None:
    """The end of each step asks for these alone; the arguments of states may cost much."""
    dag = make.dag
    laws = [dag.call(Op.ABS, dag.sub(make.t, dag.one))] * of_time
    laws += [dag.call(Op.ABS, dag.sub(make.x, dag.one))] * of_states
    lowered = lower(optimise(make.program(sum_of(dag, laws))))
    stores = {kernel.name: len(kernel.stores) for kernel in lowered.kernels}
    assert stores["switches"] == of_time + of_states
    assert stores.get("timed_switches") == (1 if of_time and of_states else None)


@pytest.mark.parametrize("shared", [True, False])
def test_the_rates_keep_what_makes_arguments_cheap(
    make: Maker, tmp_path: Path, shared: bool
) -> None:
    """An argument that takes the rates' own operations is known behind them, whatever the mode."""
    dag, bent = make.dag, make.x
    for _ in range(20):
        bent = dag.call(Op.SIN, bent)
    arguments = [dag.sub(bent if shared else make.x, dag.one), dag.sub(make.t, make.u)]
    law = sum_of(dag, [dag.call(Op.ABS, argument) for argument in arguments])
    emitted = emit_model(optimise(make.program(dag.add(law, bent))), "0")
    kernels = {kernel.name: kernel for kernel in emitted.lowered.kernels}
    assert len(kernels["rhs"].left) == shared
    assert ("switches_after_rhs" in kernels) == shared
    if shared:
        model = CompiledModel(emitted, tmp_path, [2.0])
        here = (0.3, np.array([0.7]), np.array([0.1]))
        expected = model.switches(*here)
        model.work[:] = np.nan
        model.rhs(*here)
        np.testing.assert_array_equal(model.switches_after_rhs(*here), expected)


def sum_of(dag: Dag, nodes: Sequence[int]) -> int:
    total = dag.zero
    for node in nodes:
        total = dag.add(total, node)
    return total


@pytest.mark.parametrize(
    ("op", "operation"),
    [
        (Op.LT, Jump.ABOVE),
        (Op.LE, Jump.NOT_BELOW),
        (Op.SIGN, Jump.SIGN),
        (Op.FLOOR, Jump.FLOOR),
        (Op.CEIL, Jump.CEIL),
        (Op.FMOD, Jump.TRUNC),
    ],
)
def test_discontinuous_operations_do(make: Maker, op: Op, operation: Jump) -> None:
    single = op in {Op.SIGN, Op.FLOOR, Op.CEIL}
    (switch,) = make.switches(make.dag.call(op, *((make.x,) if single else (make.p, make.x))))
    assert switch.operation is operation
    assert switch.jumps and not switch.timed
    assert switch.states == ("x0",)


@pytest.mark.parametrize(("op", "value"), [(Op.ABS, 3), (Op.MIN, -3), (Op.MAX, 2)])
def test_kinks_do_and_do_not_jump(make: Maker, op: Op, value: float) -> None:
    dag = make.dag
    node = dag.call(op, make.x) if op == Op.ABS else dag.call(op, make.x, make.p)
    held, (switch,) = hold_modes(make.program(node))
    assert switch.operation is Jump.NOT_BELOW
    assert not switch.jumps and not switch.timed
    states_ = at([-3.0], p=[2.0], u=[0.0, math.nan])
    (derivative,) = (state.derivative for state in held.states)
    assert evaluate_nodes(held.dag, [derivative], states_) == [value]
    # In the other mode, the other piece goes on.
    (argument,) = evaluate_nodes(held.dag, [switch.argument], states_)
    other = at([-3.0], p=[2.0], u=[0.0, float(not argument >= 0)])
    assert evaluate_nodes(held.dag, [derivative], other) == [2 if op == Op.MIN else -3]


def test_switches_of_time_come_first_and_inputs_do_not_make_them_less_timed(make: Maker) -> None:
    dag = make.dag
    of_state = dag.call(Op.LT, make.x, make.p)
    of_time = dag.call(Op.LT, dag.mul(make.u, make.t), make.p)
    first, second = make.switches(dag.add(of_state, of_time))
    assert first.timed and not second.timed


def test_a_switch_of_state_and_time_is_not_timed(make: Maker) -> None:
    dag = make.dag
    (both,) = make.switches(dag.call(Op.LT, make.x, dag.call(Op.SIN, make.t)))
    assert not both.timed and both.states == ("x0",)


def test_a_law_that_is_continuous_at_its_switch_is_known_to_be(make: Maker) -> None:
    dag, x, p = make.dag, make.x, make.p
    over = dag.sub(x, p)
    slack = dag.select(dag.call(Op.LT, p, x), dag.mul(p, over), dag.zero)
    damped = dag.select(dag.call(Op.LT, p, x), dag.mul(p, x), dag.zero)
    negated = dag.select(dag.call(Op.NOT, dag.call(Op.LE, x, dag.zero)), x, dag.zero)
    assert [s.jumps for s in make.switches(slack)] == [False]
    assert [s.jumps for s in make.switches(damped)] == [True]
    assert [s.jumps for s in make.switches(negated)] == [False]
    # One of two laws that it switches jumps.
    assert [s.jumps for s in make.switches(dag.add(slack, damped))] == [True]


def test_a_sign_and_a_size_at_the_start_of_a_root_raise_no_event(make: Maker) -> None:
    dag, x = make.dag, make.x
    size, sign = dag.call(Op.ABS, x), dag.call(Op.SIGN, x)
    root = dag.call(Op.SQRT, dag.mul(make.p, size))
    assert make.switches(dag.mul(sign, root)) == ()
    assert make.switches(dag.pow(size, dag.const(1.75))) == ()
    (jump,) = make.switches(dag.mul(sign, dag.add(root, dag.one)))
    assert jump.operation is Jump.SIGN and jump.jumps
    # Where the root begins elsewhere, and where there is none, they do.
    later = dag.call(Op.SQRT, dag.add(size, dag.one))
    assert [s.jumps for s in make.switches(later)] == [False]
    assert [s.jumps for s in make.switches(dag.mul(sign, x))] == [False]


def test_places_in_the_source_stay_with_an_operation(make: Maker) -> None:
    dag = make.dag
    source = Source("a.bg", "if x < y then 1")
    less = dag.call(Op.LT, make.x, make.p)
    dag.mark(less, Span(source, 3, 8))
    dag.mark(less, Span(source, 0, 1))  # the first one stays
    (moved,) = dag.substitute([less], {make.x: dag.mul(make.x, make.t)})
    (switch,) = make.switches(moved)
    assert switch.place is not None and switch.place.text == "x < y"
    dag.mark(make.x, Span(source, 3, 4))
    assert make.x not in dag.places


# --- kernels -----------------------------------------------------------------------------------


def test_kernels_read_modes_and_compare_without(make: Maker, tmp_path) -> None:
    dag, x, t = make.dag, make.x, make.t
    node = dag.sum(
        (
            dag.select(dag.call(Op.LT, x, dag.const(1)), dag.mul(x, x), dag.neg(x)),
            dag.mul(dag.const(100), dag.call(Op.SIGN, dag.sub(x, dag.const(3)))),
            dag.mul(dag.const(1000), dag.call(Op.FMOD, t, dag.const(2))),
            dag.mul(dag.const(10000), dag.call(Op.FLOOR, x)),
        )
    )
    program = make.program(node, outputs=[node])
    emitted = emit_model(program, "0")
    kinds = [switch.operation for switch in emitted.lowered.switches]
    assert sorted(kinds) == [Jump.ABOVE, Jump.SIGN, Jump.FLOOR, Jump.TRUNC]
    model = CompiledModel(emitted, tmp_path, [2.0])
    u = np.zeros(1)
    for value, time in ((0.5, 1.0), (1.5, 5.0), (4.0, 7.5)):
        (expected,) = evaluate_nodes(program.dag, [node], at([value], t=time, u=u))
        assert model.rhs(time, np.array([value]), u)[0] == pytest.approx(expected)
    held = {Jump.ABOVE: 1, Jump.SIGN: -1, Jump.TRUNC: 2, Jump.FLOOR: 7}
    modes = [float(held[kind]) for kind in kinds]
    expected = 4.5**2 - 100 + 1000 * (7.5 - 2 * 2) + 10000 * 7
    found = model.rhs(7.5, np.array([4.5]), u, modes)
    assert found[0] == pytest.approx(expected)
    assert model.outputs(7.5, np.array([4.5]), u, modes)[0] == pytest.approx(expected)
    jac, dfdt = model.entries(7.5, np.array([4.5]), u, modes)
    assert jac[0] == pytest.approx(9) and dfdt[0] == pytest.approx(1000)
    arguments = dict(zip(kinds, model.switches(7.5, np.array([4.5]), u), strict=True))
    assert arguments == pytest.approx(
        {Jump.ABOVE: -3.5, Jump.SIGN: 1.5, Jump.TRUNC: 3.75, Jump.FLOOR: 4.5}
    )


def test_one_switch_in_the_argument_of_another(make: Maker) -> None:
    """`fmod(time, 2) < 1` has a linear argument in each mode of the quotient."""
    dag = make.dag
    phase = dag.call(Op.FMOD, make.t, dag.const(2))
    condition = dag.call(Op.LT, phase, dag.one)
    held, switches = hold_modes(make.program(dag.select(condition, make.x, dag.zero)))
    assert [s.operation for s in switches] == [Jump.TRUNC, Jump.ABOVE]
    assert all(s.timed for s in switches)
    modes = {1: 3.0, 2: math.nan}  # input 0 is the program's own
    values = at([1.0], t=7.5, u=[0.0, modes[1], modes[2]])
    assert evaluate_nodes(held.dag, [switches[1].argument], values) == [1 - (7.5 - 6)]


@pytest.mark.parametrize(
    ("law", "back"),
    [
        ("0.7*sign(e)*sqrt(abs(e))", 0.7),
        ("-sign(-e)*sqrt(abs(e))*0.7", 0.7),
        ("0.7*sign(e)/2*2*abs(e)^0.5", 0.7),
        ("if e > 0 then 0.7*sqrt(e) else -0.7*sqrt(-e)", 0.7),
        ("0.7*(sqrt(max(e, 0)) - sqrt(max(-e, 0)))", 0.7),
        ("if e > 0 then 0.7*sqrt(e) else 0", 0.0),
        ("0.7*sqrt(max(e, 0))", 0.0),
    ],
)
def test_orifices_are_crossed_however_they_are_written(law, back, tmp_path):
    """A step that begins at the infinite slope of a root would stay there, without an error."""
    path = tmp_path / "m.bg"
    path.write_text(
        "model M { feed : Sf(f = cos(2*time)); node : J0; tank : C(0.5);"
        f"hole : R {{ f = {law}; }}"
        "feed -> node -> tank, hole; } scene s of M { observe tank.e as e; run 6 s every 0.1 s; }"
    )

    def slope(t, e):
        return (np.cos(2 * t) - np.where(e > 0, 0.7, -back) * np.sqrt(np.abs(e))) / 0.5

    result = bgc.compile(path, preview=True).simulate()
    exact = solve_ivp(slope, (0, 6), [0.0], t_eval=result.time, rtol=1e-9, atol=1e-10)
    assert np.abs(result["e"] - exact.y[0]).max() < 2e-3
    assert result.counts["steps"] < 1000 and result.counts["events"] == 0


def rectified(rng: random.Random, depth: int) -> str:
    """An expression that is positive where v is, and else zero."""
    if depth == 0:
        return rng.choice(
            ["max(v, 0)", "(abs(v) + v)", "(if v > 0 then v else 0)", "(v - min(v, -v))"]
        )
    inner = rectified(rng, depth - 1)
    return rng.choice(
        [
            f"max({inner}, 0)",
            f"(0.1*{inner} + 0.2*{inner})",
            f"sin({inner}/9)*w",
            f"({inner})^2",
            "(0.3*w*abs(v) + (0.1*v + 0.2*v)*w)",
            f"({inner} + {rectified(rng, depth - 1)})",
        ]
    )


@pytest.mark.parametrize("seed", range(12))
def test_a_condition_that_compares_equal_values_on_one_side_is_met_on_time(seed, tmp_path):
    """The argument of such a switch is zero until another kink has changed: `if abs(v) > v`."""
    rng = random.Random(seed)
    r = rectified(rng, rng.randint(0, 3))
    condition = rng.choice(
        ["{} > 0", "sign({}) > 0", "not {} <= 0", "v < v + {}", "ceil({}/99) > 0"]
    )
    branches = rng.choice(["then 5 else 2", "then 3*v*w else -v"])
    text = (
        "model M {{ state v = -0.7; state y = 0; state w = 2; der(w) = -0.2*w;"
        "der(v) = 1.9*cos(1.7*time + 0.3) + 0.1*sin(v); der(y) = if {} {}; }}"
        "scene s of M {{ observe y; run 6 every 0.25; }}"
    )
    results = []
    for name, met in (("plain", "v > 0"), ("other", condition.format(r))):
        path = tmp_path / f"{name}.bg"
        path.write_text(text.format(met, branches))
        model = bgc.compile(path, preview=True)
        runs = [
            {"rtol": 1e-10},
            {"rtol": 1e-8, "solver": "dopri5"},
            {"solver": "rk4", "step": 0.01},
        ]
        results.append(np.array([model.simulate(**options)["y"] for options in runs]))
    np.testing.assert_allclose(results[1], results[0], rtol=0, atol=1e-6, err_msg=r)
