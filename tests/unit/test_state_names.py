"""Merged states are called after the coordinate that they belong to, each by a name of its own."""

import re
from pathlib import Path

import pytest

import bgc.library
from bgc.driver import compile_scene
from bgc.options import Options
from bgc.resolution.resolve import load_text

LIBRARY = Path(bgc.library.__file__).parent
MODELS = Path(__file__).parents[1] / "models"

NAMED = {
    "junction of the flow": (
        "s : Se(e = 1); shaft : J1; lay : J1; g : TF(3); a : I(1); b : I(2);"
        "s -> shaft -> a; shaft -> g -> lay -> b;",
        ["shaft.p"],
    ),
    "port of a transformer": (
        "s : Se(e = 1); state a = 0; der(a) = 1; m : I[2](1); s -> rod -> m;"
        "rod : MTF { f2 = [[sin(a)], [cos(a)]]*f1; }",
        ["rod.p1"],
    ),
    "component of a wide port": (
        "s : Se(e = 1); rod : TF { f2 = [[1], [2]]*f1; } m : I[2](1); s -> rod -> m;",
        ["rod.p2[1]"],
    ),
    "component of a wide junction": (
        "s : Se[2](e = 1); hub : J1[2]; a : I[2](1); b : I[2](2); s -> hub -> a, b;",
        ["hub.p[1]", "hub.p[2]"],
    ),
    "part of an array": (
        "for i in 1..2 { s[i] : Se(e = 1); shaft[i] : J1; a[i] : I(1); b[i] : I(2);"
        "s[i] -> shaft[i] -> a[i], b[i]; }",
        ["shaft[1].p", "shaft[2].p"],
    ),
    "outermost of several junctions": (
        "s : Se(e = 1); inner : Pair; j : J1; c : I(1); s -> j -> inner, c;",
        ["j.p"],
    ),
    "charges in parallel": (
        "s : Sf(f = 1); node : J0; a : C(1); b : C(2); s -> node -> a, b;",
        ["node.q"],
    ),
}


def state_names(text):
    package = load_text(
        f"model Pair {{ port p in; k : J1; x : I(5); p -> k -> x; }}\n{text}", "m.bg"
    )
    stages = compile_scene(Path("m.bg"), Options(), package=package, until="equations")
    return [state.name for state in stages.equations.states]


@pytest.mark.parametrize("case", NAMED)
def test_a_merged_state_is_called_after(case):
    body, expected = NAMED[case]
    names = state_names(f"model M {{ {body} }} scene s of M {{ observe time as t; run 1 s; }}")
    assert [name for name in names if name in expected] == expected


def test_components_that_newtons_method_finds_have_names_of_their_own():
    body = """s : Sf[2](f = 1); node : J0[2]; b : C[2](2); s -> node -> a, b;
    a : C[2] { e[1] = q[1] + tanh(q[1]); e[2] = q[2] + erf(q[2]); }"""
    names = state_names(f"model M {{ {body} }} scene s of M {{ observe a.e; run 1 s; }}")
    assert names == ["node.q[1]", "node.q[2]", "b.q[1]", "b.q[2]"]


def test_an_element_without_a_junction_gives_its_own_name():
    ring = """for k in 1..3 { n[k] : J1; g[k] : GY(2 + k); c[k] : C(1); n[k] -> c[k], g[k]; }
    g[1] -> n[2]; g[2] -> n[3]; g[3] -> n[1];"""
    names = state_names(f"model M {{ {ring} }} scene s of M {{ observe time as t; run 1 s; }}")
    assert names == ["c[1].merged.q", "c[3].merged.q"]


@pytest.mark.parametrize(
    "path",
    [*sorted(LIBRARY.glob("examples/*.bg")), MODELS / "rigid_crane.bg", MODELS / "gyrator_ring.bg"],
    ids=lambda path: path.stem,
)
def test_names_of_states_are_paths_and_unique(path):
    program = compile_scene(path, Options(), until="equations").equations
    names = [state.name for state in program.states]
    assert len(set(names)) == len(names)
    assert all(re.fullmatch(r"[\w.]+(\[\d+(,\d+)?\])?(\.\w+(\[\d+\])?)*", name) for name in names)
