"""Initial values of merged storage with nonlinear laws hold at the start, or are refused."""

from __future__ import annotations

import math
import random
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
from model_files import compiled
from refusals import refusal
from scipy.integrate import solve_ivp
from scipy.optimize import brentq, minimize

import bgc
from bgc.diagnostics.diagnostic import BgError

CUBIC = "{ f = p + p^3; }"
TWO = """model M {{ j : J1; a : {a} b : {b} r : R(1); j -> a, b, r; }}
scene s of M {{ observe a.p, b.p, a.f, b.f; run 1 s; }}"""
PAIR = """model M {{ j : J0; a : {a} b : {b} r : R(1); j -> a, b, r; }}
scene s of M {{ observe a.q, b.q, a.e, b.e; run 1 s; }}"""


def start_of(folder: Path, text: str, **parameters: float) -> dict[str, float]:
    return compiled(folder, text).observe(parameters=parameters)


def refused(folder: Path, text: str) -> tuple[str, str]:
    diagnostic = refusal(compiled, folder, text)
    return diagnostic.code, diagnostic.message


def root(function: Callable[[float], float]) -> float:
    return float(brentq(function, -100, 100, xtol=1e-15))


def cubic(flow: float, factor: float = 1.0) -> float:
    return root(lambda p: p + factor * p**3 - flow)


@pytest.mark.parametrize(
    ("a", "b", "expected"),
    [
        ("I(p0 = 1) { f = p/2; }", "I { f = p + p^3; }", (1, cubic(0.5), 0.5)),
        ("I(2, p0 = 1);", "I { f = p + p^3; }", (1, cubic(0.5), 0.5)),
        ("I(p0 = 1) { f = p/2; }", "I { f = p/3; }", (1, 1.5, 0.5)),
        ("I(2);", "I(p0 = 0.5) { f = p + p^3; }", (1.25, 0.5, 0.625)),
        ("I(2, f0 = 0.5);", "I { f = p + p^3; }", (1, cubic(0.5), 0.5)),
        ("I(2);", "I(f0 = 0.5) { f = p + p^3; }", (1, cubic(0.5), 0.5)),
    ],
)
def test_values_of_merged_inertias_hold(
    a: str, b: str, expected: tuple[float, float, float], tmp_path: Path
) -> None:
    found = list(start_of(tmp_path, TWO.format(a=a, b=b)).values())
    assert found == pytest.approx([*expected, expected[-1]], rel=1e-12)


@pytest.mark.parametrize("given", ["q0 = 1", "e0 = 0.5"])
@pytest.mark.parametrize("law", ["{ e = q + q^3; }", "{ H = q^2/2 + q^4/4; }"])
def test_values_of_merged_compliances_hold(given: str, law: str, tmp_path: Path) -> None:
    found = start_of(tmp_path, PAIR.format(a=f"C(2, {given});", b=f"C {law}"))
    assert list(found.values()) == pytest.approx([1, cubic(0.5), 0.5, 0.5], rel=1e-12)


def test_a_saturating_coil_carries_the_current_that_is_given(tmp_path: Path) -> None:
    """With any parameters: the runtime solves for the start again."""
    text = """model M { param i0 : A = 0.5 A; param k = 1; loop : J1; leak : I(2 H, f0 = i0);
      core : I { f = p/1 H + k*1 A*(p/1 Wb)^3; } wire : R(1 ohm); loop -> leak, core, wire; }
    scene s of M { observe leak.f as i, leak.p, core.p; run 1 s; }"""
    model = compiled(tmp_path, text)
    for current, k in [(0.5, 1), (-0.5, 1), (1e-9, 1), (5, 0.1), (1e6, 1), (0.5, 1e4), (0, 3)]:
        found = model.observe(parameters={"i0": current, "k": k})
        expected = [current, 2 * current, cubic(current, k)]
        assert list(found.values()) == pytest.approx(expected, rel=1e-12, abs=1e-15)
    result = model.simulate(parameters={"i0": 2})
    assert [result[x][0] for x in ("i", "leak.p", "core.p")] == pytest.approx([2, 4, 1], rel=1e-12)


def test_parameters_beyond_the_reach_of_a_law_are_refused(tmp_path: Path) -> None:
    text = """model M { param i0 = 0.5; j : J1; a : I(1, f0 = i0); b : I { f = tanh(p); }
      j -> a, b; } scene s of M { observe a.f as i; run 1 s; }"""
    model = compiled(tmp_path, text)
    assert model.observe(parameters={"i0": 0.999})["i"] == pytest.approx(0.999, rel=1e-12)
    diagnostic = refusal(model.observe, parameters={"i0": 2})
    assert diagnostic.code == "BG732" and "`a`" in diagnostic.message
    code, message = refused(tmp_path, text.replace("i0 = 0.5", "i0 = 2"))
    assert (code, "`f0` of `a`" in message) == ("BG517", True)


@pytest.mark.parametrize(
    ("text", "culprit"),
    [
        # An inertia that a gyrator holds at rest, and one without freedom between resistances.
        (
            """model M { n1 : J1; n2 : J1; i : I(p0 = 0.37) { f = p/3.8 + 0.12*p^3; }
              x : MGY[2] { e = [[0, 3.9], [-3.9, 0]]*f; } n1 -> i; n2 -> x[1]; n1 -> x[2]; }
            scene s of M { observe i.p; run 1 s; }""",
            "`p0` of `i` contradicts what drives or holds it",
        ),
        (
            """model M { n3 : J1; n4 : J0; n5 : J1; i : I(p0 = 0.19) { f = 3.3*p + 0.4*abs(p)*p; }
              r : R[2](conductance = [[0.58, -0.96], [0.56, 0.84]]); m1 : Mux[1, 1];
              x : MGY { e2 = [[-0.41, 0.24]]*f1; } m2 : Mux[1, 1];
              y : MTF { f2 = [[0.77, 1.36]]*f1; } n3 -> i; n5 -> r[1]; n3 -> r[2];
              n4, n4 -> m1 -> x; n4, n3 -> m2 -> y; y -> n3; x -> n3; }
            scene s of M { observe i.p; run 1 s; }""",
            "`p0` of `i` contradicts what drives or holds it",
        ),
        (TWO.format(a="I(2, p0 = 1);", b=f"I(f0 = 0.6) {CUBIC}"), "`f0` of `b` contradicts the"),
        (TWO.format(a="I(2, p0 = 1);", b=f"I(p0 = 0.5) {CUBIC}"), "`p0` of `b` contradicts the"),
        (PAIR.format(a="C(2, q0 = 1);", b="C(e0 = 0.6) { e = q + q^3; }"), "`e0` of `b` contrad"),
    ],
)
def test_contradictions_name_the_culprit(text: str, culprit: str, tmp_path: Path) -> None:
    code, message = refused(tmp_path, text)
    assert code == "BG516" and message.startswith(culprit)


def test_values_that_agree_are_taken(tmp_path: Path) -> None:
    b = f"I(p0 = {cubic(0.5)!r}, f0 = 0.5) {CUBIC}"
    with pytest.raises(BgError):  # one determines the other
        start_of(tmp_path, TWO.format(a="I(2, p0 = 1);", b=b))
    found = start_of(tmp_path, TWO.format(a="I(2, p0 = 1);", b=f"I(f0 = 0.5) {CUBIC}"))
    assert found["b.p"] == pytest.approx(cubic(0.5), rel=1e-12)


def test_a_value_that_follows_without_any_storage_is_taken(tmp_path: Path) -> None:
    parts = "s : Se(e = 4); j : J1(f0 = 2); r : R(2); s -> j -> r;"
    text = f"model M {{ {parts} }} scene s of M {{ observe j.f; run 1 s; }}"
    assert start_of(tmp_path, text) == {"j.f": 2.0}


def test_what_is_not_given_has_the_least_energy(tmp_path: Path) -> None:
    """Three masses on flows u, v and u + v; the energies are those of the laws."""
    text = """model M { a : I A b : I B c : I(p0 = 0.8) C u : J1; v : J1; w : J1; sum : J0;
      u -> a; v -> b; w -> c; u -> sum; v -> sum; sum -> w; }
    scene s of M { observe a.p, b.p, c.p, a.f, b.f, c.f; run 1 s; }"""
    laws = {"A": (1.0, 1.0), "B": (0.5, 2.0), "C": (2.0, 0.3)}
    for name, (k, m) in laws.items():
        text = text.replace(f" {name} ", f" {{ f = {k}*p + {m}*p^3; }} ")
    found = list(start_of(tmp_path, text).values())

    def momentum(name: str, flow: float) -> float:
        k, m = laws[name]
        return root(lambda p: k * p + m * p**3 - flow)

    def energy(name: str, flow: float) -> float:
        (k, m), p = laws[name], momentum(name, flow)
        return k / 2 * p**2 + m / 4 * p**4

    total = 2.0 * 0.8 + 0.3 * 0.8**3
    best = minimize(lambda u: energy("A", u[0]) + energy("B", total - u[0]), [0.5], tol=1e-14).x[0]
    expected = [momentum("A", best), momentum("B", total - best), 0.8]
    assert found[:3] == pytest.approx(expected, rel=1e-6)
    assert found[3] + found[4] == pytest.approx(found[5], rel=1e-13)
    assert found[2] == pytest.approx(0.8, rel=1e-14)


def test_a_common_flow_or_effort_may_be_given(tmp_path: Path) -> None:
    text = TWO.replace("j : J1;", "j : J1(f0 = 0.5);").format(a="I(2);", b=f"I {CUBIC}")
    assert start_of(tmp_path, text)["a.f"] == pytest.approx(0.5, rel=1e-12)
    text = PAIR.replace("j : J0;", "j : J0(e0 = 0.5);").format(a="C(2);", b="C { e = q + q^3; }")
    assert start_of(tmp_path, text)["b.q"] == pytest.approx(cubic(0.5), rel=1e-12)
    text = PAIR.replace("j : J0;", "j : J0(e0 = 0.5);").format(a="C(2);", b="C(3);")
    assert start_of(tmp_path, text)["b.q"] == pytest.approx(1.5, rel=1e-12)
    text = PAIR.replace("j : J0;", "j : J0(e0 = 0.5);").format(a="C(2, q0 = 2);", b="C(3);")
    assert refused(tmp_path, text)[0] == "BG516"


LAWS = (
    ("{k}*{x}", lambda k, m, x: k * x),
    ("{k}*{x} + {m}*{x}^3", lambda k, m, x: k * x + m * x**3),
    ("{k}*{x} + {m}*abs({x})*{x}", lambda k, m, x: k * x + m * abs(x) * x),
    ("{k}*{x} + {m}*tanh({x})", lambda k, m, x: k * x + m * math.tanh(x)),
    ("{k}*{x} + {m}*exp({x}) - {m}", lambda k, m, x: k * x + m * math.expm1(x)),
)


@pytest.mark.parametrize("seed", range(12))
@pytest.mark.parametrize("dual", [False, True])
def test_random_starts_that_have_a_solution_are_found(
    seed: int, dual: bool, tmp_path: Path
) -> None:
    """Flows of a tree of junctions are drawn; values that follow from them are given."""
    rng = random.Random(seed)
    one, two, kind, state, common = (
        ("J0", "J1", "C", "q", "e") if dual else ("J1", "J0", "I", "p", "f")
    )
    count = rng.randint(2, 4)
    flows = [rng.uniform(-2, 2) for _ in range(count)]
    lines, truth = [], {}
    for j, members in enumerate(
        [[k] for k in range(count)] + [[k, k + 1] for k in range(count - 1)]
    ):
        lines.append(f"n{j} : {one}; r{j} : R({rng.uniform(0.5, 2)!r}); n{j} -> r{j};")
        if len(members) > 1:
            lines.append(f"s{j} : {two}; s{j} -> n{j};")
            lines += [f"n{k} -> s{j};" for k in members]
        flow = sum(flows[k] for k in members)
        for i in range(rng.randint(1, 2)):
            text, law = rng.choice(LAWS)
            k, m = rng.uniform(0.2, 3), rng.uniform(0.2, 3)
            x = root(lambda x, law=law, k=k, m=m, flow=flow: law(k, m, x) - flow)
            given = rng.choice((f"({state}0 = {x!r})", f"({common}0 = {flow!r})"))
            given = given if len(members) == 1 and i == 0 else ""
            text = text.format(k=repr(k), m=repr(m), x=state)
            lines.append(f"x{j}_{i} : {kind}{given} {{ {common} = {text}; }} n{j} -> x{j}_{i};")
            truth[f"x{j}_{i}.{state}"] = x
    scene = f"scene s of M {{ observe {', '.join(truth)}; run 1; }}"
    found = start_of(tmp_path, f"model M {{ {' '.join(lines)} }} {scene}")
    assert found == pytest.approx(truth, rel=1e-10, abs=1e-10)


def random_storage(seed: int) -> tuple[str, dict[str, float]]:
    """A random graph of nonlinear storage, gyrators among it, and the values that it is given."""
    rng = random.Random(seed)
    given: dict[str, float] = {}
    kinds = [rng.choice(("J0", "J1")) for _ in range(rng.randint(2, 5))]
    lines = []

    def some(share: float, name: str, variable: str) -> str:
        if rng.random() >= share:
            return ""
        given[f"{name}.{variable}"] = round(rng.uniform(-1, 1), 2)
        return f"({variable}0 = {given[f'{name}.{variable}']})"

    for i, kind in enumerate(kinds):
        lines.append(f"n{i} : {kind}{some(0.1, f'n{i}', 'e' if kind == 'J0' else 'f')};")
        way = rng.choice(("", "", f"TF({rng.uniform(0.3, 3)!r})", f"GY({rng.uniform(0.3, 3)!r})"))
        if i and way:
            lines.append(f"t{i} : {way}; n{i} -> t{i} -> n{rng.randrange(i)};")
        elif i:
            lines.append(f"n{i} -> n{rng.randrange(i)};")
        for j in range(rng.randint(1, 3)):
            name, element = f"x{i}_{j}", rng.choice("IICCIR")
            state, left = {"I": ("p", "f"), "C": ("q", "e"), "R": ("f", "e")}[element]
            k, m = rng.uniform(0.2, 3), rng.uniform(0.2, 3)
            law = rng.choice(LAWS)[0].format(k=repr(k), m=repr(m), x=state)
            start = "" if element == "R" else some(0.35, name, rng.choice((state, left)))
            lines.append(f"{name} : {element}{start} {{ {left} = {law}; }} n{i} -> {name};")
    text = f"model M {{ {' '.join(lines)} z : J1; c : C(1); r : R(1); z -> c, r; }}\n"
    return f"{text}scene s of M {{ observe {', '.join(['c.q', *given])}; run 1; }}", given


@pytest.mark.parametrize("first", range(0, 48, 8))
def test_given_values_hold_or_are_refused(first: int, tmp_path: Path) -> None:
    held = 0
    for seed in range(first, first + 8):
        text, given = random_storage(seed)
        (tmp_path / "model.bg").write_text(text)
        try:
            found = bgc.compile(tmp_path / "model.bg", preview=True).observe()
        except BgError as error:
            refusals = {"BG516", "BG517", "BG515", "BG513", "BG501"}
            assert {d.code for d in error.diagnostics} <= refusals, f"seed {seed}"
            continue
        held += bool(given)
        kept = {name: found[name] for name in given}
        assert kept == pytest.approx(given, rel=1e-12, abs=1e-12), f"seed {seed}"
    assert held


def test_a_flow_that_follows_from_rates_cannot_be_given(tmp_path: Path) -> None:
    text = """model M { n : J1(f0 = 1); a : C(1); b : C { e = q + q^3; } s : Se(e = 3);
      s -> n -> a, b; }
    scene s of M { observe a.q; run 1 s; }"""
    code, message = refused(tmp_path, text)
    assert (code, "does not follow from charges" in message) == ("BG515", True)


def test_a_given_rate_holds_beside_a_held_one(load):
    """The momenta of least energy among those of the given rate would move the held coordinate."""
    result = load("held_start", "start").simulate(rtol=1e-9)
    assert result["free.f"][0] == pytest.approx(0.5, rel=1e-12)
    np.testing.assert_allclose(result["zero"], 0, atol=1e-12)

    def across(b):  # of f = 1, with the second coordinate held
        return np.array([[0.6, 0.8], [-0.8, 0.6]]) @ [np.cos(b), np.sin(b)]

    def inertia(b):
        return across(b) @ np.diag([2, 3]) @ across(b)

    def rate(t, f):
        b = 0.4 + 0.7 * t
        turned = 0.7 * np.array([[0.6, 0.8], [-0.8, 0.6]]) @ [-np.sin(b), np.cos(b)]
        return -across(b) @ np.diag([2, 3]) @ turned * f / inertia(b)

    exact = solve_ivp(rate, (0, 1), [0.5], t_eval=result.time, rtol=1e-11, atol=1e-12)
    np.testing.assert_allclose(result["free.f"], exact.y[0], rtol=1e-8)


@pytest.mark.parametrize(("rate", "refused"), [("5 m/s", True), ("-0.3/cos(0.1)*1 m/s", False)])
def test_a_rate_that_a_closed_chain_contradicts_is_refused(tmp_path, rate, refused):
    """The modulus may vanish: the source closes a chain, at the start with `f0` of the body."""
    path = tmp_path / "chain.bg"
    path.write_text(f"""
model M {{
  state x : m = 0.1 m; der(x) = way.f;
  way : J1; node : J0; gear : MTF(cos(x / 1 m));
  body : I(2 kg, f0 = {rate});
  feed : Sf(f = 0.3 m/s);
  feed -> node; way -> gear -> node; way -> body;
}}
scene s of M {{ observe way.f; run 1 s; }}
""")
    if refused:
        with pytest.raises(bgc.BgError, match="BG516"):
            bgc.compile(path)
    else:
        assert bgc.compile(path).simulate()["way.f"][0] == pytest.approx(-0.3 / np.cos(0.1))


def test_a_given_position_holds_where_a_loop_has_several_solutions(tmp_path: Path) -> None:
    """Beside a plain spring, up to five positions of this one have the same total charge."""
    text = """model Snap { param at : m = 1.6 m; node : J0; plain : C(stiffness = 1 N/m);
      snap : C(q0 = at) { e = 0.2 N/m * q + 1 N * sin(q/0.5 m); } leak : R(10 N*s/m);
      node -> plain, snap, leak; }
    scene s of Snap { observe snap.q, snap.e, plain.q; run 1 s; }"""
    model = compiled(tmp_path, text)
    for at in (-5.0, -4.0, -1.0, 0.7, 1.2, 1.6, 2.4, 4.6, 5.2):
        found = list(model.observe(parameters={"at": at}).values())
        effort = 0.2 * at + math.sin(at / 0.5)
        assert found == pytest.approx([at, effort, effort], rel=1e-12, abs=1e-12)


@pytest.mark.parametrize("given", ["q0 = 0.34 rad", "e0 = 0.5 N*m"])
def test_a_value_holds_beside_a_field_that_starts_jointly(given: str, tmp_path: Path) -> None:
    """The field shares a state with the spring of each junction; only its own start is joint."""
    text = f"""model Pair {{ left : J0; right : J0; gear : MGY(1.3 N*m*s/rad);
      spring : C(compliance = 0.71 rad/N/m, {given}); field : C[2](stiffness = 1.3 N*m/rad);
      far : C(0.61 rad/N/m); farther : C(stiffness = 0.39 N*m/rad, e0 = 0.64 N*m);
      left -> spring, gear, field[1]; gear -> right; right -> far, farther, field[2]; }}
    scene s of Pair {{ observe spring.q, spring.e, field.e, far.e, farther.q; run 1 s; }}"""
    effort = 0.34 / 0.71 if given.startswith("q") else 0.5
    expected = [0.71 * effort, effort, effort, 0.64, 0.64, 0.64 / 0.39]
    found = list(compiled(tmp_path, text).observe().values())
    assert found == pytest.approx(expected, rel=1e-12)


LEVER = """model M {{ a : J1{of_a} ma : I({ma}); a -> ma; b : J1; mb : I({mb}); b -> mb;
  lever : MTF {{ f2 = {ratio}*f1; }} a -> lever -> b; pull : Se(1); pull -> a; }}
scene s of M {{ observe a.f, b.f, ma.p, mb.p; run 1 s; }}"""


@pytest.mark.parametrize(
    ("given", "column", "ratio"),
    [
        ({"ma": "1, f0 = 0.5"}, "a.f", "(1 + sin(b.f))"),
        ({"ma": "1, p0 = 0.5"}, "ma.p", "(1 + sin(b.f))"),
        ({"mb": "2, f0 = 0.5"}, "b.f", "(1 + sin(b.f))"),
        ({"mb": "2, p0 = 0.5"}, "mb.p", "(1 + sin(b.f))"),
        ({"of_a": "(f0 = 0.5);"}, "a.f", "(1 + sin(b.f))"),
        ({"ma": "1, f0 = 0.5"}, "a.f", "(1 + sin(mb.p))"),
        ({"ma": "1, f0 = 0.5"}, "a.f", "(1 + sin(ma.p))"),
        ({"mb": "2, p0 = 0.5"}, "mb.p", "(1 + sin(ma.p))"),
    ],
)
def test_values_hold_behind_a_modulus_of_flows_and_momenta(
    given: dict[str, str], column: str, ratio: str, tmp_path: Path
) -> None:
    """The modulus is that of the start, not of a standstill."""
    parts = {"of_a": ";", "ma": "1", "mb": "2"} | given
    found = start_of(tmp_path, LEVER.format(ratio=ratio, **parts))
    assert found[column] == pytest.approx(0.5, rel=1e-12)
    read = found[ratio.removeprefix("(1 + sin(").removesuffix("))")]
    assert found["b.f"] == pytest.approx((1 + math.sin(read)) * found["a.f"], rel=1e-12)
    assert found["ma.p"] == pytest.approx(found["a.f"], rel=1e-12)
    assert found["mb.p"] == pytest.approx(2 * found["b.f"], rel=1e-12)


def test_given_values_that_parameters_set_apart_are_refused(tmp_path: Path) -> None:
    """Values that agree by default are one condition of the start, and each run checks both."""
    text = """model M { param u = 1; param v = 1; j : J1; a : I(2, f0 = u); b : I(3, f0 = v);
      r : R(1); j -> a, b, r; } scene s of M { observe a.f, b.f; run 1 s; }"""
    model = compiled(tmp_path, text)
    assert model.observe(parameters={"u": 2, "v": 2}) == {"a.f": 2, "b.f": 2}
    assert model.observe(parameters={"v": 1 + 1e-9})["a.f"] == 1  # rounding
    for values in ({"v": 2}, {"u": 1.00001}, {"v": 0}):
        diagnostic = refusal(model.observe, parameters=values)
        assert diagnostic.code == "BG732" and "`f0` of `b`" in diagnostic.message
        assert diagnostic.span is not None
        refusal(model.simulate, parameters=values)


def test_a_default_that_gave_way_is_refused_once_it_is_set(tmp_path: Path) -> None:
    text = """model Body { param start = 0; port p; m : I(2, f0 = start); p -> j; j : J1; j -> m; }
      model M { param u = 1; x : Body; y : Body(start = u); j : J1; j -> x.p; j -> y.p;
        r : R(1); j -> r; }
      scene s of M { keep x.start; observe x.m.f, y.m.f; run 1 s; }"""
    model = compiled(tmp_path, text)
    assert model.observe() == {"x.m.f": 1, "y.m.f": 1}
    assert refusal(model.observe, parameters={"x.start": 3}).code == "BG732"
    assert model.observe(parameters={"x.start": 3, "u": 3}) == {"x.m.f": 3, "y.m.f": 3}


def test_a_start_at_rest_takes_given_values_as_wishes(tmp_path: Path) -> None:
    text = """model M { param u = 1; param v = 1; j : J1; a : I(2, f0 = u); b : I(3, f0 = v);
      r : R(1); j -> a, b, r; } scene s of M { observe a.f, b.f; start rest; run 1 s; }"""
    model = compiled(tmp_path, text)
    result = model.simulate(parameters={"v": 2})
    assert [result["a.f"][0], result["b.f"][0]] == pytest.approx([0, 0], abs=1e-12)


def test_a_wide_body_behind_a_matrix_of_a_momentum_starts_as_given(tmp_path: Path) -> None:
    text = """model M { a : J1[3]; ma : I[3](1); a -> ma; b : J1[2]; b -> mb;
      mb : I[2](inertia = [[2, 0.5], [0.5, 3]], f0 = [0.9, -0.7]);
      turn : MTF[3, 2] { f2 = [[1, 0.5*sin(ma.p[1]), cos(ma.p[1])],
        [0, 1, 0.8*sin(ma.p[1])]]*f1; }
      a -> turn -> b; } scene s of M { observe mb.f; run 1 s; }"""
    found = list(start_of(tmp_path, text).values())
    assert found == pytest.approx([0.9, -0.7], rel=1e-12)


def test_a_projection_that_moves_a_declared_start_is_refused(tmp_path: Path) -> None:
    """A quaternion in four digits counts as rounded; another length does not."""
    path = tmp_path / "turned.bg"
    path.write_text("""
model Turned {
  param w = 0.7071;
  state h[2] : 1 = [w, 0.7071];
  der(h) = [-h[2]/(1 s), h[1]/(1 s)];
  project h = h/norm(h);
}
scene turned of Turned { observe h; run 1 s; }
""")
    model = bgc.compile(path, preview=True)
    result = model.simulate()
    assert result["h[1]"][0] == pytest.approx(np.sqrt(0.5), rel=1e-12)
    with pytest.raises(bgc.BgError, match=r"BG732: `h\[1\]` does not start at its initial value"):
        model.simulate(parameters={"w": 0.71})


def test_a_field_starts_of_which_one_port_answers_by_its_flow(tmp_path: Path) -> None:
    """The body's flows give `u = n' e` behind a gyrator; least energy makes the charges q = C e
    a multiple of n."""
    text = """model M { gap : J0; speed : J1[4]; state at = 0.21; der(at) = speed.f[4];
      rotor : MGY[1, 4] { e2 = [[9.7], [7*cos(at)], [3.9], [0]]*f1; } gap -> rotor -> speed;
      body : I[4](inertia = 1.2, f0 = [0.72, 0.59, 0.51, 1.5]); speed -> body;
      lever : TF[1, 2] { e1 = [[2.5, 0.66]]*e2; } hub : J0[2]; gap -> lever -> hub;
      field : C[2](compliance = [[1.9, -0.96], [-0.96, 1.7]]); hub -> field; }
    scene s of M { observe body.f, field.e, field.q; run 1 s; }"""
    found = compiled(tmp_path, text).observe()
    flows = [0.72, 0.59, 0.51, 1.5]
    assert [found[f"body.f[{k}]"] for k in range(1, 5)] == pytest.approx(flows, rel=1e-12)
    u = np.dot([9.7, 7 * np.cos(0.21), 3.9, 0], flows)
    n, capacity = np.array([2.5, 0.66]), np.array([[1.9, -0.96], [-0.96, 1.7]])
    charges = n * u / (n @ np.linalg.solve(capacity, n))
    assert [found["field.q[1]"], found["field.q[2]"]] == pytest.approx(charges, rel=1e-9)


def test_momenta_that_turn_their_own_gyrators_start_as_given(tmp_path: Path) -> None:
    """The initial value of a momentum merged behind them depends on itself."""
    text = """model M { a : J1[2]; ma : I[2]([[2.4, 0.4], [0.4, 1.8]], p0 = [-0.4, 2.2]); a -> ma;
      hub : J0[3]; lever : TF[2, 3] { e1 = [[0.4, 1.8, -2], [0, 0.4, -0.6]]*e2; }
      a -> lever -> hub; gap : J0[3]; hub -> turn -> gap; gap -> spring, mb;
      turn : MGY[3, 3] { e1 = [[0.5, 0, 0], [1.1, 2.3, 0],
        [-0.4*sin(ma.p[2]), 2.6*cos(ma.p[2]), 0.4]]*f2; }
      spring : C[3]([[2.8, -0.3, -0.2], [-0.3, 2.3, 0.4], [-0.2, 0.4, 1.9]], e0 = [2, -1.4, -0.4]);
      mb : I[3](2, f0 = [-0.6, -0.4, -1.6]); far : J0[2]; hub -> turn2 -> far; far -> soft, mc;
      turn2 : MGY[3, 2] { e1 = [[0.9, 0], [2*cos(ma.p[1]), 0.5],
        [0.8*sin(ma.p[1]), -1.6*sin(ma.p[1])]]*f2; }
      soft : C[2](0.5); mc : I[2](2, f0 = [0.5, 0.3]); }
    scene s of M { observe ma.p, spring.e, mb.f, mc.f; run 1 s; }"""
    found = list(start_of(tmp_path, text).values())
    given = [-0.4, 2.2, 2, -1.4, -0.4, -0.6, -0.4, -1.6, 0.5, 0.3]
    assert found == pytest.approx(given, rel=1e-10)
