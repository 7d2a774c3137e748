"""The laws of elements: which form each written equation becomes in the flat graph."""

import pytest
from test_elaborate import element, flat

from bgc.algebra.dag import Kind, Symbol
from bgc.algebra.evaluate import evaluate_nodes


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
