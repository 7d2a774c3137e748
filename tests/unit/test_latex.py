r"""Equations as LaTeX: read back and evaluated, and parsed by matplotlib's mathtext."""

import math
import re
from pathlib import Path

import numpy as np
import pytest
from matplotlib.mathtext import MathTextParser
from programs import at, make_program

from bgc.algebra.dag import Dag, Kind, Op
from bgc.algebra.evaluate import evaluate_nodes
from bgc.driver import compile_scene
from bgc.options import Options
from bgc.printing.latex import latex_equations
from bgc.printing.latex_names import dotted, latex_name, latex_names
from bgc.printing.stages import symbol_names

MODELS = Path(__file__).parents[1] / "models"
NAMES = ["a", "b", "k1", "omega", "mass"]


class Reader:
    """Evaluates a formula in the subset of LaTeX that the tests need."""

    def __init__(self, text: str, values: dict[str, float]) -> None:
        pattern = r"\\(?:[a-z]+|,)|_\{[^{}]*(?:\{[^{}]*\})?[^{}]*\}|[\d.]+|[a-zA-Z]|[-+^{}()]"
        self.tokens = re.findall(pattern, text.replace("&", "").replace("\\quad", ""))
        self.values = values

    def take(self, expected: str | None = None) -> str:
        token = self.tokens.pop(0)
        assert expected is None or token == expected, (token, expected)
        return token

    def next_is(self, *tokens: str) -> bool:
        return bool(self.tokens) and self.tokens[0] in tokens

    def sum(self) -> float:
        total, sign = 0.0, 1
        if self.next_is("-"):
            self.take()
            sign = -1
        total = sign * self.product()
        while self.next_is("+", "-"):
            total += (1 if self.take() == "+" else -1) * self.product()
        return total

    def product(self) -> float:
        value = self.power()
        while self.next_is(r"\,", r"\cdot"):
            self.take()
            value *= self.power()
        return value

    def power(self) -> float:
        base = self.atom()
        if self.next_is("^"):
            self.take()
            base **= self.braced()
        return base

    def braced(self) -> float:
        self.take("{")
        value = self.sum()
        self.take("}")
        return value

    def bracketed(self) -> float:
        for token in (r"\left", "("):
            self.take(token)
        value = self.sum()
        for token in (r"\right", ")"):
            self.take(token)
        return value

    def atom(self) -> float:
        if self.next_is(r"\left"):
            return self.bracketed()
        token = self.take()
        if re.fullmatch(r"[\d.]+", token):
            return float(token)
        match token:
            case r"\frac":
                return self.braced() / self.braced()
            case r"\sqrt":
                return math.sqrt(self.braced())
            case r"\sin" | r"\cos":
                return getattr(math, token[1:])(self.bracketed())
            case r"\mathit":
                token += self.take("{")
                while not self.next_is("}"):
                    token += self.take()
                token += self.take("}")
        if self.tokens and self.tokens[0].startswith("_{"):
            token += self.take()
        return self.values[token]


def equations_of(text: str) -> list[tuple[str, str]]:
    """All equations, each on one line."""
    bodies = re.findall(r"\\begin\{align\*\}\n(.*?)\n\\end\{align\*\}", text, re.DOTALL)
    lines = [
        line for body in bodies for line in re.split(r" \\\\\n  (?! )", re.sub("^  ", "", body))
    ]
    pairs = [line.split(" &= ") for line in lines]
    assert all(len(pair) == 2 for pair in pairs), lines
    return [(left, right.replace("\\\\\n      ", "")) for left, right in pairs]


def random_nodes(seed: int) -> tuple[Dag, list[int]]:
    rng = np.random.default_rng(seed)
    dag = Dag()
    nodes = [dag.symbol(Kind.PARAM, k) for k in range(5)]
    nodes += [dag.const(2), dag.const(0.25), dag.const(-3), dag.const(1234.5)]
    for _ in range(120):
        a, b = (nodes[k] for k in rng.integers(0, len(nodes), 2))
        match rng.integers(9):
            case 0 | 1:
                nodes.append(dag.add(a, b))
            case 2 | 3:
                nodes.append(dag.sub(a, b))
            case 4 | 5:
                nodes.append(dag.mul(dag.call(Op.SIN, a), b))
            case 6:
                nodes.append(dag.div(a, dag.add(dag.const(3), dag.call(Op.COS, b))))
            case 7:
                nodes.append(dag.neg(dag.mul(dag.call(Op.COS, a), dag.call(Op.COS, a))))
            case _:
                root = dag.call(Op.SQRT, dag.add(dag.const(2), dag.call(Op.SIN, a)))
                nodes.append(dag.sub(root, b))
    return dag, nodes[-4:]


@pytest.mark.parametrize("seed", range(30))
def test_what_is_printed_has_the_value_of_the_nodes(seed):
    dag, roots = random_nodes(seed)
    program = make_program(
        dag, roots, parameters=[(name, dag.one) for name in NAMES], outputs=[roots[0]]
    )
    numbers = [0.7, -1.3, 2.1, 0.4, 1.9]
    text = latex_equations(program, symbol_names(program))
    values = {latex_name(name): x for name, x in zip(NAMES, numbers, strict=True)}
    for left, right in equations_of(text):
        reader = Reader(right, values)
        values[left] = reader.sum()
        assert reader.tokens == [], right
    expected = evaluate_nodes(dag, roots, at([], p=numbers))
    found = [values[dotted(latex_name(state.name))] for state in program.states]
    np.testing.assert_allclose(found, expected, rtol=1e-9)


@pytest.mark.parametrize(
    ("name", "scene"),
    [("dc_motor", None), ("duffing", None), ("vessel_at_rest", "rolling"), ("lock_damping", None)],
)
@pytest.mark.slow
def test_mathtext_takes_every_equation(name, scene):
    program = compile_scene(MODELS / f"{name}.bg", Options(scene), until="optimise").optimised
    text = latex_equations(program, symbol_names(program))
    parser = MathTextParser("path")
    found = equations_of(text)
    for left, right in found:
        parser.parse(f"${left} = {right}$")
    lefts = [left for left, _ in found]
    assert all(dotted(latex_name(s.name)) in lefts for s in program.states)
    assert all(latex_name(o.name) in lefts for o in program.observations)


def test_auxiliary_quantities_are_defined_before_they_are_used():
    program = compile_scene(
        MODELS / "vessel_at_rest.bg", Options("rolling"), until="optimise"
    ).optimised
    defined: set[str] = set()
    for left, right in equations_of(latex_equations(program, symbol_names(program))):
        assert set(re.findall(r"\\eta_\{\d+\}", right)) <= defined
        defined.add(left)
    assert any(left.startswith(r"\eta") for left in defined)


def test_products_become_fractions_and_powers():
    def printed(node: int) -> str:
        program = make_program(dag, [node], parameters=[(name, dag.one) for name in NAMES])
        return equations_of(latex_equations(program, symbol_names(program)))[-1][1]

    dag = Dag()
    a, b, k, w, m = (dag.symbol(Kind.PARAM, i) for i in range(5))
    assert printed(dag.mul(dag.div(dag.one, b), a)) == r"\frac{a}{b}"
    assert printed(dag.neg(dag.div(dag.mul(k, dag.mul(a, a)), m))) == (
        r"-\frac{k_{1}\,a^{2}}{\mathit{mass}}"
    )
    assert printed(dag.mul(dag.const(0.5), w)) == r"\frac{\omega}{2}"
    assert printed(dag.sub(dag.add(a, b), dag.sub(b, a))) == r"2\,a"
    assert printed(dag.mul(a, dag.sub(b, k))) == r"a\,\left(b - k_{1}\right)"


def test_a_choice_is_set_as_cases():
    dag = Dag()
    a, b = (dag.symbol(Kind.PARAM, k) for k in range(2))
    node = dag.select(dag.call(Op.LT, a, b), a, dag.mul(b, b))
    program = make_program(dag, [node], parameters=[(name, dag.one) for name in NAMES])
    (_, right), *_ = equations_of(latex_equations(program, symbol_names(program)))
    assert right == (r"\begin{cases} a & \text{if } a < b \\ b^{2} & \text{otherwise} \end{cases}")


@pytest.mark.parametrize(
    ("name", "expected"),
    [
        ("R", "R"),
        ("mass", r"\mathit{mass}"),
        ("theta0", r"\theta_{0}"),
        ("omega_x", r"\omega_{x}"),
        ("d_max", r"d_{\mathrm{max}}"),
        ("coil.p", r"p_{\mathrm{coil}}"),
        ("crane.boom_1.p[3]", r"p_{\mathrm{crane.boom\_1},3}"),
        ("gear.p1", r"p_{1,\mathrm{gear}}"),
        ("hand.position[1,2]", r"\mathit{position}_{\mathrm{hand},1,2}"),
        ("time", "t"),
    ],
)
def test_names(name, expected):
    assert latex_name(name) == expected
    assert dotted(latex_name("coil.p")) == r"\dot{p}_{\mathrm{coil}}"


def test_a_mass_matrix_stands_on_the_left():
    dag = Dag()
    x, y = (dag.symbol(Kind.STATE, k) for k in range(2))
    p = dag.symbol(Kind.PARAM, 0)
    program = make_program(
        dag, [y, dag.sub(x, y)], parameters=[("a", dag.one)], mass=[(0, 0, p), (0, 1, dag.one)]
    )
    found = equations_of(
        latex_equations(program, lambda s: "xy"[s.index] if s.kind is Kind.STATE else "a")
    )
    assert found[0][0] == r"a\,\dot{x}_{0} + \dot{x}_{1}"
    assert found[1][0] == "0"


def test_names_that_would_look_alike_are_written_out():
    names = latex_names(["x1", "x_1", "x__1", "omega", "t", "time", "x1"])
    assert len(set(names.values())) == len(names)
    assert names["omega"] == r"\omega"
    assert dotted(names["x_1"]) == r"\dot{\mathit{x\_1}}"
