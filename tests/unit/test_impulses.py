"""Warnings for flows and efforts with impulses, where a source that jumps drives storage."""

from pathlib import Path

import pytest

from bgc.algebra.dag import Dag, Kind, Op
from bgc.algebra.discontinuities import jumps_in
from bgc.algebra.fingerprint import Fingerprints
from bgc.driver import compile_scene
from bgc.options import Options
from bgc.resolution.resolve import load_text

JUMPING = (
    "if time < 1 then 0 else 5",
    "sign(time - 1)",
    "floor(time)",
    "ceil(2*x)",
    "fmod(time, 2)",
    "time*floor(time)",
    "time - floor(time)",
    "if x > 1 then 5 else 0",
    "if x > 1 and time < 3 then x - 1 else 0",
    "if sin(time) > 0 then 1 else 0",
)
CONTINUOUS = (
    "sin(time)",
    "abs(sin(time))",
    "max(0, time - 1)",
    "if time < 1 then 0 else time - 1",
    "if 2*time > 1 then time - 0.5 else 0",
    "if x^2 > time then x^2 - time else 0",
    "sin(time)*sign(sin(time))",
    "if sin(time) > 0 then sin(time) else 0",
    "(time - floor(time))*(1 - (time - floor(time)))",
)
# Graphs with a value X that determines what an element stores, what is read, what is named.
GRAPHS = {
    "a C parallel to an Se": ("s : Se(e = X); n : J0; c : C(2); s -> n -> c;", "c.f", "c"),
    "its energy": ("s : Se(e = X); n : J0; c : C(2); s -> n -> c;", "energy.residual", "c"),
    "the source's flow": ("s : Se(e = X); n : J0; c : C(2); s -> n -> c;", "s.f", "c"),
    "an I on an Sf": ("s : Sf(f = X); n : J1; c : I(2); s -> n -> c;", "c.e", "c"),
    "an I behind transformers": (
        "s : Sf(f = X); n : J1; t : TF(3); u : TF(2); k : J1; c : I(2); r : R(1);"
        "s -> n -> t -> u -> k -> c, r;",
        "s.e",
        "c",
    ),
    "two C in a loop": ("s : Se(e = X); j : J1; a : C(1); b : C(2); s -> j -> a, b;", "a.f", "a"),
    "a modulus between inertias": (
        "s : Se(e = 1); j : J1; k : J1; t : MTF(20 + (X)); a : I(1); b : I(2);"
        "s -> j -> a; j -> t -> k -> b;",
        "a.p",
        "t",
    ),
    "a part in a slot": ("s : Se(e = X); n : J0; p : Store; s -> n -> p;", "s.f", "p.c"),
}
SILENT = {
    "an R in series": ("s : Se(e = X); n : J1; c : C(2); r : R(1); s -> n -> c, r;", "c.f"),
    "a charge alone": ("s : Se(e = X); n : J0; c : C(2); s -> n -> c;", "c.q"),
    "an R parallel": ("s : Sf(f = X); n : J0; c : C(2); s -> n -> c;", "c.f"),
}


def warnings(graph, value, observed):
    text = f"""interface Any {{ port p; }} model Store is Any {{ port p; c : C(3); p -> c; }}
    model M {{ state x = 0; der(x) = 1; {graph.replace("X", value)} }}
    scene s of M {{ observe {observed}; run 1 s; }}"""
    package = load_text(text, "m.bg")
    found = compile_scene(Path("m.bg"), Options(), package=package, until="equations").warnings
    return [w for w in found if w.code == "BG541"]


@pytest.mark.parametrize("value", JUMPING)
@pytest.mark.parametrize("graph", GRAPHS)
def test_a_value_that_jumps_gives_impulses(graph, value):
    text, observed, name = GRAPHS[graph]
    (warning,) = warnings(text, value, observed)
    assert f"`{name}`" in warning.message and warning.help


@pytest.mark.parametrize("value", CONTINUOUS)
@pytest.mark.parametrize("graph", GRAPHS)
def test_a_continuous_value_gives_none(graph, value):
    text, observed, _ = GRAPHS[graph]
    assert warnings(text, value, observed) == []


@pytest.mark.parametrize("value", JUMPING)
@pytest.mark.parametrize("graph", SILENT)
def test_storage_of_its_own_and_values_that_only_jump_give_none(graph, value):
    assert warnings(SILENT[graph][0], value, SILENT[graph][1]) == []


def test_the_place_of_the_jump_is_underlined():
    text, observed, _ = GRAPHS["a C parallel to an Se"]
    (warning,) = warnings(text, "if time < 1 then 0 else 5", observed)
    assert [label.span.text for label in warning.labels] == ["time < 1"]


def test_jumps_of_a_node():
    dag = Dag()
    x, y = dag.symbol(Kind.STATE, 0), dag.symbol(Kind.STATE, 1)
    above = dag.call(Op.LT, y, x)
    fingerprints = Fingerprints(dag)
    assert jumps_in(dag, fingerprints, above) == [above]
    ramp = dag.select(above, dag.sub(x, y), dag.zero)
    assert jumps_in(dag, fingerprints, ramp) == []
    assert jumps_in(dag, fingerprints, dag.mul(ramp, above)) == []
    assert jumps_in(dag, fingerprints, dag.add(ramp, above)) == [above]
