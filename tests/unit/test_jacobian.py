"""`jacobian`: against derivations by hand, SymPy, and the typologies of the library."""

from __future__ import annotations

import itertools
import math
from pathlib import Path

import numpy as np
import pytest
import sympy
from fake_scope import World

from bgc.algebra.dag import Kind, Symbol
from bgc.algebra.evaluate import evaluate_nodes
from bgc.driver import compile_scene
from bgc.ir.program import Program
from bgc.options import Options
from bgc.resolution.resolve import load_text

PINS = (
    "boom_pins = [1.485 m, 2.831 m], boom_offset = 0.8, jib_pins = [2.955 m, 1.002 m], "
    "jib_offset = 1.1"
)
# Arguments, coordinates, joints, and the forms.
TYPOLOGIES = {
    "Planar2R": ("l1 = 2 m, l2 = 1.5 m", "angles", 2, (2, 3)),
    "Planar3R": ("links = [2 m, 1.5 m, 0.7 m]", "angles", 3, (2, 3)),
    "Slew2R": ("l1 = 2 m, l2 = 1.5 m", "angles", 3, (3, 6)),
    "SlewLuffTelescope": ("length = 2 m", "coordinates", 3, (3, 6)),
    "KnuckleBoom": (f"l1 = 2 m, l2 = 1.5 m, {PINS}", "coordinates", 3, (3, 6)),
    "Gantry": ("", "coordinates", 3, (3, 6)),
    "Cylindrical": ("", "coordinates", 3, (3, 6)),
    "Scara": ("l1 = 2 m, l2 = 1.5 m", "coordinates", 4, (3, 4, 6)),
    "Anthropomorphic6R": ("l1 = 2 m, l2 = 1.5 m, l3 = 0.4 m", "angles", 6, (3, 6)),
}
SINGULAR = (0.0, math.pi / 2, math.pi, -math.pi / 2, -2.0)  # -2: a telescope of length 0


def program_of(text: str) -> Program:
    package = load_text(text, "model.bg")
    return compile_scene(Path("model.bg"), Options(), package=package, until="equations").equations


def observed(program: Program, states: list[float]) -> dict[str, float]:
    """The observations of a program at given states."""
    dag = program.dag
    values = {s: states[s.index] for s in dag.symbols if s.kind is Kind.STATE}
    for parameter in program.parameters:
        (number,) = evaluate_nodes(dag, [parameter.value], values)
        values[Symbol(Kind.PARAM, parameter.index)] = number
    found = evaluate_nodes(dag, [o.node for o in program.observations], values)
    return {o.name: x for o, x in zip(program.observations, found, strict=True)}


def postures(name: str, count: int) -> list[tuple[float, ...]]:
    """Random and singular ones: every combination of angles that are so, or 100 of these."""
    rng = np.random.default_rng(5)
    if name == "KnuckleBoom":  # jib in line with the boom at 2.70 m; luffed by 90 deg at 3.92 m
        straight = math.sqrt(2.955**2 + 1.002**2 - 2 * 2.955 * 1.002 * math.cos(1.1))
        upright = math.sqrt(1.485**2 + 2.831**2 - 2 * 1.485 * 2.831 * math.cos(math.pi / 2 + 0.8))
        lengths = rng.uniform((-4, 1.5, 2.1), (4, 4.1, 3.8), (20, 3))
        return [(0.3, 2.5, straight), (0.0, upright, straight), *map(tuple, lengths)]
    singular = list(itertools.product(SINGULAR, repeat=count))
    if len(singular) > 125:
        singular = [tuple(rng.choice(SINGULAR, count)) for _ in range(100)]
    return [*singular, *map(tuple, rng.uniform(-4, 4, (20, count)))]


@pytest.mark.parametrize("name", TYPOLOGIES)
def test_typologies_are_the_jacobians_of_their_positions(name: str) -> None:
    """In each form; rates of the axes R are those of the angular velocity: R' = S(w) R."""
    arguments, joints, count, forms = TYPOLOGIES[name]
    arms = "".join(
        f"arm{m} : {name}[{m}]({joints} = q{', ' if arguments else ''}{arguments});\n"
        f"load{m} : Se[{m}](e = zeros({m})); drive{m} : Sf[{count}](f = zeros({count}));\n"
        f"drive{m} -> arm{m} -> load{m};\n"
        for m in forms
    )
    first, last = f"arm{forms[0]}", f"arm{forms[-1]}"
    program = program_of(f"""
import arms.kinematics;
model Arm {{
  state q[{count}];
  der(q) = zeros({count});
  {arms}
}}
scene s of Arm {{
  observe {", ".join(f"arm{m}.jacobian as form{m}" for m in forms)},
    jacobian({first}.position, {first}.{joints}) as made, jacobian({first}.position, q) as by_state,
    {last}.axes as axes, jacobian({last}.axes*[1, 0, 0], q) as forward,
    jacobian({last}.axes*[0, 1, 0], q) as aside;
  run 1;
}}
""")
    for point in postures(name, count):
        found = observed(program, [float(x) for x in point])

        def matrix(key: str, found: dict[str, float] = found) -> np.ndarray:
            rows = max(
                int(n[len(key) + 1 :].split(",")[0]) for n in found if n.startswith(f"{key}[")
            )
            return np.array(
                [
                    [found[f"{key}[{i + 1},{j + 1}]"] for j in range(count if key != "axes" else 3)]
                    for i in range(rows)
                ]
            )

        velocity, axes = matrix("made"), matrix("axes")
        np.testing.assert_allclose(matrix("by_state"), velocity, rtol=0, atol=1e-14)
        np.testing.assert_allclose(axes @ axes.T, np.eye(3), atol=1e-14)
        for m in forms:
            own = matrix(f"form{m}")
            linear = own[: len(velocity)]
            np.testing.assert_allclose(linear, velocity, rtol=0, atol=1e-14)
            if m == len(velocity):
                continue
            turning = np.zeros((3, count))
            turning[3 - m + len(velocity) :] = own[len(velocity) :]
            for key, column in (("forward", 0), ("aside", 1)):
                expected = np.cross(turning.T, axes[:, column]).T
                np.testing.assert_allclose(matrix(key), expected, rtol=0, atol=1e-14)


def test_inputs_that_are_constant_or_equal_have_derivatives_of_their_own() -> None:
    """An angle of zero, minus a state, and one state twice: the general expression counts."""
    program = program_of("""
model Arm {
  input a;
  input b;
  input c = 0;
  output tip[2] = [c*a + cos(b)*a^2, sin(a + 2*b) + a/(1 + c)];
}
model World {
  state q = 0.3;
  der(q) = 0;
  arm : Arm(a = -q, b = q);
  signal slopes[2, 3] = jacobian(arm.tip, [arm.a, arm.b, arm.c]);
  signal total[2, 1] = jacobian(arm.tip, [q]);
}
scene s of World { observe slopes, total; run 1; }
""")
    found = observed(program, [0.7])
    a, b, c = sympy.symbols("a b c")
    tip = sympy.Matrix([c * a + sympy.cos(b) * a**2, sympy.sin(a + 2 * b) + a / (1 + c)])
    there = {a: -0.7, b: 0.7, c: 0}
    expected = np.array(tip.jacobian([a, b, c]).subs(there), float)
    slopes = [[found[f"slopes[{i},{j}]"] for j in (1, 2, 3)] for i in (1, 2)]
    np.testing.assert_allclose(slopes, expected, rtol=1e-14, atol=1e-15)
    total = expected[:, 1] - expected[:, 0]
    np.testing.assert_allclose([found["total[1,1]"], found["total[2,1]"]], total, rtol=1e-13)


def test_what_is_not_in_the_list_is_held() -> None:
    """A signal is varied by itself, whatever it is computed from, here and through a bond."""
    program = program_of("""
domain Line { effort F : N; flow v : m/s; signal r : m; }
model Tail {
  port tip out : Line;
  input place : m;
  tip.r = 2*place;
  push : Se(e = 1 N);
  push -> tip;
}
model World {
  state q = 0.3;
  der(q) = 0;
  signal s = q^2;
  signal way = 3*q;
  tail : Tail(place = way);
  load : R(1);
  tail -> load;
  signal held = jacobian(q*s, s);
  signal through = jacobian(tail.tip.r^2 + q, way);
  signal second = jacobian(jacobian(s^3*q, s), s);
  signal mixed = jacobian(jacobian(s^3*q, q), s);
  signal rate = jacobian(sin(q*time), time);
}
scene s of World { observe held, through, second, mixed, rate; run 1; }
""")
    dag = program.dag
    values = {Symbol(Kind.STATE, 0): 0.7, Symbol(Kind.TIME, 0): 0.2}
    nodes = [o.node for o in program.observations]
    q, s = 0.7, 0.49
    expected = [q, 2 * (2 * 3 * q) * 2, 6 * s * q, 3 * s**2, q * math.cos(q * 0.2)]
    np.testing.assert_allclose(evaluate_nodes(dag, nodes, values), expected, rtol=1e-14)


def test_arguments_of_functions_are_quantities() -> None:
    world = World(
        "function slope(u) = jacobian(u^3 + g(u, u), u);\nfunction g(a, b) = jacobian(a^2*b, a);"
    )
    assert world.numbers("slope(2)")[0] == pytest.approx(3 * 4 + 4 * 2)
    assert world.numbers("slope(x)")[0] == pytest.approx(3 * 4 + 4 * 2)


def test_long_chains_of_definitions_do_not_exhaust_the_stack() -> None:
    lets = "\n".join(f"let a{k} = a{k - 1} + q/{k};" for k in range(1, 800))
    program = program_of(f"""
model World {{
  state q = 1;
  der(q) = 0;
  signal a0 = q;
  {lets}
  signal slope = jacobian(a799, a0);
}}
scene s of World {{ observe slope; run 1; }}
""")
    assert observed(program, [1.0])["slope"] == 1


@pytest.mark.parametrize(
    ("text", "shape"),
    [("jacobian(x, x)", ()), ("jacobian(v, x)", (3,)), ("jacobian(x, [x])", (1, 1)),
     ("jacobian(v, v)", (3, 3)), ("jacobian(x, v[1..2])", (1, 2))],
)  # fmt: skip
def test_shapes(text: str, shape: tuple[int, ...]) -> None:
    assert World().evaluate(text).shape == shape


def test_units_are_those_of_quotients() -> None:
    value = World().evaluate("jacobian(3 kg * v, v[1])")
    assert value.units[0] == World().evaluate("3 kg").units[0]
