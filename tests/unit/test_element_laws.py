"""The laws of elements: which form each written equation becomes in the flat graph."""

from fractions import Fraction

import pytest
from test_elaborate import element, flat, number

from bgc.algebra.dag import Kind, Symbol
from bgc.algebra.evaluate import evaluate_nodes
from bgc.ir.graph import EnergyLaw, ExplicitLaw, Form, Gyristor, LinearLaw


def law_of(kind: str, body: str):
    text = f"model M {{ param k = 2; s : Se(e = 1); x : {kind} {{ {body} }} s -> x; }}"
    graph = flat(text)
    return graph, element(graph, "x").law


@pytest.mark.parametrize(
    ("kind", "body", "form"),
    [
        ("C", "e = k*q;", Form.EFFORT),
        ("C", "q = k*e;", Form.DISPLACEMENT),
        ("I", "f = p/k;", Form.FLOW),
        ("I", "p = k*f;", Form.MOMENTUM),
        ("R", "e = k*f;", Form.EFFORT),
        ("R", "f = k*e;", Form.FLOW),
    ],
)
def test_linear_equations_give_linear_laws(kind, body, form):
    _, law = law_of(kind, body)
    assert isinstance(law, LinearLaw)
    assert law.form is form


def test_nonlinear_equations_and_energies():
    graph, law = law_of("R", "e = k*f + abs(f)*f;")
    assert isinstance(law, ExplicitLaw)
    assert law.form is Form.EFFORT
    _, law = law_of("C", "e = k*q^3;")
    assert isinstance(law, ExplicitLaw)
    graph, law = law_of("IC", "H = p^2/(2*k) + k*q^2/2;")
    assert isinstance(law, EnergyLaw)
    kinds = {graph.dag.symbol_of(n).kind for n in graph.dag.reachable([law.energy])
             if graph.dag.symbol_of(n)}  # fmt: skip
    assert kinds == {Kind.PARAM, Kind.DISPLACEMENT, Kind.MOMENTUM}


@pytest.mark.parametrize(
    ("body", "given", "entry"),
    [
        ("f2 = 3*f1;", "f2", 3),
        ("e1 = 3*e2;", "e1", 3),
        ("f1 = f2/3;", "f1", Fraction(1, 3)),
        ("e2 = e1/3;", "e2", Fraction(1, 3)),
    ],
)
def test_each_equation_of_a_transformer(body, given, entry):
    text = f"model M {{ s : Se(e = 1); t : TF {{ {body} }} r : R(1); s -> t -> r; }}"
    graph = flat(text)
    transformer = element(graph, "t")
    assert transformer.given == given
    assert number(graph, transformer.matrix[0][0]) == entry


@pytest.mark.parametrize("body", ["e2 = 4*f1;", "e1 = 4*f2;", "f2 = e1/4;", "f1 = e2/4;"])
def test_each_equation_of_a_gyrator(body):
    text = f"model M {{ s : Se(e = 1); g : GY {{ {body} }} r : R(1); s -> g -> r; }}"
    graph = flat(text)
    assert number(graph, element(graph, "g").matrix[0][0]) == 4


@pytest.mark.parametrize(
    "body",
    [
        "e2 = [[1, 2], [3, 5]]*f1;",
        "e1 = [[1, 3], [2, 5]]*f2;",
        "f1 = [[-5, 2], [3, -1]]*e2;",
        "f2 = [[-5, 3], [2, -1]]*e1;",
        "f1 = inv([[1, k], [3, 5]])*e2;",
    ],
)
def test_each_equation_of_a_wide_gyrator(body):
    text = (
        f"model M {{ param k = 2; s : Se[2](e = 1); g : GY {{ {body} }} r : R[2](1);"
        "s -> g -> r; } scene x of M { observe r.f; run 1 s; }"
    )
    graph = flat(text)
    (two,) = (p.index for p in graph.parameters)
    entries = [node for row in element(graph, "g").matrix for node in row]
    values = {Symbol(Kind.PARAM, two): 2.0}
    assert evaluate_nodes(graph.dag, entries, values) == pytest.approx([1, 2, 3, 5])


@pytest.mark.parametrize("bonds", ["m -> a; g -> m; m -> r;", "g -> m; m -> r; m -> a;"])
@pytest.mark.parametrize("kind, body", [("MGY", "e1 = m.f*f2;"), ("MTF", "f1 = m.f*f2;")])
def test_a_modulus_may_read_the_flow_of_its_junction_in_any_order_of_bonds(bonds, kind, body):
    text = f"""
      model M {{ s : Se(e = 1); g : {kind} {{ {body} }} m : J1; r : R(1); a : I(1); s -> g;
      {bonds} }}
    """
    graph = flat(text)
    (entry,) = element(graph, "g").matrix[0]
    reads = {graph.dag.symbol_of(n) for n in graph.dag.reachable([entry])}
    assert {Kind.FLOW} == {symbol.kind for symbol in reads if symbol}


def test_matrices_of_efforts_are_transposed():
    text = """
      model M {{ s : Se[2](e = 1); t : TF {{ {} }} r : R(1); s -> t -> r; }}
    """
    one = element(flat(text.format("e1 = [[1], [2]]*e2;")), "t")
    two = element(flat(text.format("f2 = [[1, 2]]*f1;")), "t")
    assert len(one.matrix) == len(two.matrix) == 1
    assert len(one.matrix[0]) == len(two.matrix[0]) == 2


def test_both_directions_of_a_rotation():
    text = """
      model M {
        state a = 0; der(a) = 1;
        let B = [[cos(a), -sin(a)], [sin(a), cos(a)]];
        s : Se[2](e = 1); r : R(1);
        turn : MTF { f2 = transpose(B)*f1; f1 = B*f2; }
        s -> turn -> r;
      }
    """
    transformer = element(flat(text), "turn")
    assert transformer.given == "f2"
    assert transformer.inverse == tuple(zip(*transformer.matrix, strict=True))


def test_a_one_sided_gyrator_of_equation_13():
    text = """
      model M {
        s : Se[2](e = 0); h : J1; body : I[2](2);
        gyro : MGY { e = [[0, body.p[1]], [-body.p[1], 0]]*f; }
        s -> h -> body; h -> gyro;
      }
    """
    gyristor = element(flat(text), "gyro")
    assert isinstance(gyristor, Gyristor)
    assert len(gyristor.matrix) == 2


def test_initial_values_of_components():
    text = "model M { s : Se[2](e = 0); c : C[2](1, q0 = [3, 4]); s -> c; }"
    graph = flat(text)
    initial = element(graph, "c").initial
    assert [(i.port, i.variable, number(graph, i.value)) for i in initial] == [
        (0, "q", 3),
        (1, "q", 4),
    ]


def test_a_varying_source_reads_what_it_likes():
    text = """
      model M { state x = 0; der(x) = r.f; s : MSe(e = sin(time) + x); r : R(1); s -> r; }
    """
    graph = flat(text)
    source = element(graph, "s")
    values = {
        graph.dag.symbol_of(n): 0.5
        for n in graph.dag.reachable([source.value])
        if graph.dag.symbol_of(n)
    }
    assert evaluate_nodes(graph.dag, [source.value], values)[0] == pytest.approx(0.979425538604)
    flow = graph.dag.symbol_of(graph.states[0].derivative)
    assert (flow.kind, flow.index) == (Kind.FLOW, 0)
