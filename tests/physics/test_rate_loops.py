"""Loops through the rates of merged storage, against the raw equations solved by SciPy.

Moduli that depend on the momentum or charge which they join, and sources that follow an inertia
force. The references write every bond's equation and solve them for the rates at each instant.
"""

import math

import numpy as np
import pytest
from model_files import compiled
from refusals import codes_of
from scipy.integrate import solve_ivp
from scipy.optimize import brentq

from bgc.driver import compile_scene
from bgc.equations.inertias.groups import find_groups
from bgc.equations.inertias.own_momenta import elements_on_flows
from bgc.equations.storage.kinds import storage_elements
from bgc.equations.variables.definitions import Variables
from bgc.options import Options


def simulate(tmp_path, model, observed, duration=1.0, rtol=1e-10):
    text = (
        f"model M {{ {model} }}\n"
        f"scene s of M {{ observe {observed}, energy.residual; "
        f"run {duration} s every {duration / 20} s; }}"
    )
    return compiled(tmp_path, text).simulate(duration, every=duration / 20, rtol=rtol)


def reference(rates, start, times):
    return solve_ivp(rates, (0, times[-1]), start, "DOP853", times, rtol=1e-12, atol=1e-13).y


def agree(result, expected, tolerance=1e-8):
    for name, values in expected.items():
        assert np.allclose(result[name], values, rtol=tolerance, atol=tolerance), name
    assert abs(result["energy.residual"]).max() < 1e-9


def test_a_modulus_that_depends_on_the_momentum_behind_it(tmp_path):
    model = """t : MTF(1 + c*a.p); s : Se(e = 1); j : J1; k : J1; a : I(2); b : I(3);
    param c = 0.4; s -> j; j -> t -> k; k -> a; j -> b;"""
    result = simulate(tmp_path, model, "a.p, b.p, t.e1, t.e2", 2.0)

    # a.f = a.p/2 = m(a.p) b.p/3, so that b.p' = h(a.p) a.p'; 1 = b.p' + m a.p'
    def slope(x):
        return 1.5 / (1 + 0.4 * x) ** 2

    def rates(t, y):
        return [1 / (slope(y[0]) + 1 + 0.4 * y[0])]

    (a,) = reference(rates, [0.0], result["time"])
    agree(result, {"a.p": a, "b.p": 1.5 * a / (1 + 0.4 * a)})
    e2 = np.array([rates(0, [x])[0] for x in a])
    agree(result, {"t.e2": e2, "t.e1": (1 + 0.4 * a) * e2})


def test_a_modulus_that_depends_on_a_flow_of_its_own(tmp_path):
    model = """t : MTF(2 + sin(b.f)); s : Se(e = 3*cos(time)); j : J1; k : J1;
    a : I(1); b : I(0.5); r : R(0.3); s -> j; j -> t -> k; k -> a, r; j -> b;"""
    result = simulate(tmp_path, model, "a.p, b.p", 3.0)

    def rates(t, y):
        u = 2 * y[0]  # b.f
        m, turning = 2 + math.sin(u), 2 * math.cos(u)  # dm/d(b.p)
        # e = b.p' + m (a.p' + 0.3 m u),  a.p = m u
        slope = turning * u + 2 * m
        return [(3 * math.cos(t) - 0.3 * m * m * u) / (1 + m * slope)]

    (b,) = reference(rates, [0.0], result["time"])
    agree(result, {"b.p": b, "a.p": (2 + np.sin(2 * b)) * 2 * b})


def test_a_source_that_follows_an_inertia_force_adds_to_the_inertia(tmp_path):
    model = """push : MSe(e = 10*cos(time) - 2*m2.e); body : J1; m1 : I(1 kg); m2 : I(2 kg);
    push -> body -> m1, m2;"""
    result = simulate(tmp_path, model, "m1.f, m2.e", 3.0)
    t = result["time"]
    assert np.allclose(result["m1.f"], 10 * np.sin(t) / 7, atol=1e-8)
    assert np.allclose(result["m2.e"], 20 * np.cos(t) / 7, atol=1e-8)


def test_a_source_that_follows_two_inertia_forces(tmp_path):
    model = """push : MSe(e = 1 + a.e - 3*b.e); j : J1; k : J1; t : TF(2); a : I(4); b : I(0.5);
    c : C(0.2); push -> j -> a, c; j -> t -> k -> b;"""
    result = simulate(tmp_path, model, "a.f, b.f", 2.0)

    def rates(t, y):  # a.f = u, b.f = 2 u: push = 4 u' + q/0.2 + 2 (0.5 2 u')
        return [(1 - 5 * y[1]) / (4 + 2 - 4 + 3), y[0]]

    u, _ = reference(rates, [0.0, 0.0], result["time"])
    agree(result, {"a.f": u, "b.f": 2 * u})


GYRATED = """n2 : J0; n3 : J0; j : J1; s : Se(e = 2); r : R(3);
g : MGY {{ e2 = {ratio}*f1; }} c : C(stiffness = 2.0); i : I(1.58, p0 = {start});
state th = 0.4; der(th) = 0.7*n3.e;
s -> j -> n2; j -> r; n2 -> g; g -> n3; n3 -> i; n2 -> c;"""


@pytest.mark.parametrize("start", [0.0, 1.0, -2.0])
def test_a_gyrator_whose_modulus_follows_the_effort_behind_it(tmp_path, start):
    ratio = "(-1.058*(1 + 0.11*cos(2*th)))"
    result = simulate(tmp_path, GYRATED.format(ratio=ratio, start=start), "th, i.p, c.q, n3.e")

    def rates(t, y):
        th, p = y
        m = -1.058 * (1 + 0.11 * math.cos(2 * th))
        slope = 1.058 * 0.22 * math.sin(2 * th)
        # 2 q = m p/1.58; q' = (2 - 2 q)/3 - f1; p' = m f1; th' = 0.7 m f1
        flow = (2 - m * p / 1.58) / 3
        per_f1 = (slope * 0.7 * m * p + m * m) / 3.16  # q' for f1 = 1
        f1 = flow / (1 + per_f1)
        return [0.7 * m * f1, m * f1]

    th, p = reference(rates, [0.4, start], result["time"])
    m = -1.058 * (1 + 0.11 * np.cos(2 * th))
    agree(result, {"th": th, "i.p": p, "c.q": m * p / 3.16})
    e = [rates(0, state)[1] for state in zip(th, p, strict=True)]
    agree(result, {"n3.e": e})


def test_a_speed_in_a_nonlinear_rate_becomes_an_algebraic_state(tmp_path):
    model = GYRATED.format(ratio="(1 + 0.1*th)", start=0.5).replace("0.7*n3.e", "tanh(n3.e)")
    result = simulate(tmp_path, model, "th, i.p, c.q")

    def rates(t, y):
        th, p = y
        m = 1 + 0.1 * th

        def miss(f1):
            return (2 - m * p / 1.58) / 3 - f1 - (0.1 * math.tanh(m * f1) * p + m * m * f1) / 3.16

        f1 = brentq(miss, -50, 50, xtol=1e-15)
        return [math.tanh(m * f1), m * f1]

    th, p = reference(rates, [0.4, 0.5], result["time"])
    agree(result, {"th": th, "i.p": p, "c.q": (1 + 0.1 * th) * p / 3.16}, 1e-7)


@pytest.mark.parametrize(
    ("model", "state", "start", "final", "time"),
    [
        # f = 1 - 2 e = p/2 and p' = e
        ("push : MSf(f = 1 - 2*body.e); j : J1; body : I(2); push -> j -> body;",
         "body.p", 0, 2, 4),
        # the same behind an arrow that leaves the junction
        ("push : MSf(f = 1 - 2*body.e); j : J1; body : I(2); j -> push; j -> body;",
         "body.p", 0, 2, 4),
        # f = 1 - e = 3 p/2 on the side of the source, and p' = 3 e - 4 f at the mass
        ("push : MSf(f = 1 - push.e); j : J1; t : TF(ratio = 1/3); k : J1; body : I(2);"
         "r : R(4); push -> j -> t -> k; k -> body, r;", "body.p", 0.5, 2*3/(4 + 9), 2/(4 + 9)),
        # the dual: e = 3 - 2 f = q/4 and q' = f
        ("push : MSe(e = 3 - 2*spring.f); n : J0; spring : C(4); push -> n -> spring;",
         "spring.q", 0, 12, 8),
        # behind a gyrator: e = 1 - 2 f at the source, 5 f at the mass, whose p/2 = e/5
        ("push : MSe(e = 1 - 2*push.f); j : J1; g : GY(5); k : J1; body : I(2);"
         "push -> j -> g -> k -> body;", "body.p", 0, 2/5, 4/25),
    ],
    ids=["a mass", "an arrow out", "behind a gear", "a spring", "behind a gyrator"],
)  # fmt: skip
def test_a_source_that_follows_its_own_reaction_is_a_resistance(
    tmp_path, model, state, start, final, time
):
    element = state.partition(".")[0]
    given = "p0" if state.endswith("p") else "q0"
    model = model.replace(f"{element} : I(2", f"{element} : I(2, {given} = {start}")
    result = simulate(tmp_path, model, f"{state}, energy.supplied, energy.dissipated")
    expected = final + (start - final) * np.exp(-result["time"] / time)
    agree(result, {state: expected})
    assert abs(result["energy.supplied"]).max() > 1e-3  # of the source: it dissipates nothing
    if " R(" not in model:
        assert not result["energy.dissipated"].any()


def test_sources_that_follow_need_no_other_load(tmp_path):
    """A source with an inner resistance alone, and beside another source."""
    model = """open : MSf(f = 0.5*(3 - a.e)); a : J0; open -> a;
    short : MSe(e = 4*(2 - b.f)); b : J1; short -> b;
    feed : MSf(f = 2*(3 - feed.e)); c : J1; other : Sf(f = 1.5); feed -> c; other -> c;"""
    result = simulate(tmp_path, model, "a.e, open.f, b.f, short.e, feed.e, other.e")
    agree(result, {"a.e": 3, "open.f": 0, "b.f": 2, "short.e": 0, "feed.e": 2.25, "other.e": -2.25})


def test_a_source_that_does_not_fix_its_reaction_is_refused(tmp_path):
    model = """push : MSf(f = 1 - 2*body.e + 2*body.e*(1 + 0*time));
    j : J1; body : I(2); push -> j -> body;"""
    assert codes_of(simulate, tmp_path, model, "body.f") == ["BG521"]


def test_a_force_that_takes_all_inertia_away_is_refused(tmp_path):
    model = "push : MSe(e = 1 + 2*a.e); j : J1; a : I(2); b : I(2); push -> j -> a, b;"
    assert codes_of(simulate, tmp_path, model, "a.f") == ["BG520"]


def test_a_run_passes_a_fold_of_the_common_momentum(tmp_path):
    """f + n^2 f of n = 2 + cos(f) is largest at f = 1.36; 1 + n d(n f)/df only vanishes at 6.8."""
    model = """a : J1; ma : I(1, f0 = 0.2); b : J1; mb : I(1); t : MTF { f2 = (2 + cos(a.f))*f1; }
    pull : Se(1); pull -> a -> ma; a -> t -> b -> mb;"""
    result = simulate(tmp_path, model, "a.f, mb.p, mb.e", 12.0)

    def ratio(f):
        return 2 + np.cos(f)

    def mass(f):
        return 1 + ratio(f) * (ratio(f) - f * np.sin(f))

    (f,) = reference(lambda _, y: 1 / mass(y), [0.2], result["time"])
    assert f[-1] > 3.7
    force = (1 - 1 / mass(f)) / ratio(f)
    agree(result, {"a.f": f, "mb.p": ratio(f) * f, "mb.e": force}, tolerance=2e-8)
    codes = codes_of(simulate, tmp_path, model, "a.f", 60.0)
    assert codes in (["BG701"], ["BG725"])
    assert mass(6.7) > 0 > mass(6.8)


@pytest.mark.parametrize("read", ["a.f[1]", "b.f[2]", "ma.p[1]", "mb.p[2]"])
def test_wide_bodies_keep_their_momenta_behind_a_matrix_of_their_flows(read, tmp_path):
    """`A u' + N' d/dt (p) = F - R u`, with p of a stiffening law behind `N(u) u`."""
    model = f"""a : J1[2]; b : J1[2]; pull : Se[2]([1, -0.5]); pull -> a -> ma; b -> mb; b -> loss;
      ma : I[2]([[1, 0.2], [0.2, 1.5]], p0 = [0.1, 0.3]); mb : I[2] {{ f[1] = p[1] + p[1]^3;
        f[2] = p[2]/2; }} turn : MTF[2, 2] {{ f2 = [[1, 2*sin({read})], [0, 1.3]]*f1; }}
      loss : R[2](0.05); a -> turn -> b;"""
    result = simulate(tmp_path, model, "a.f, mb.p", 3.0, rtol=1e-10)
    mass = np.array([[1, 0.2], [0.2, 1.5]])

    def behind(u):  # the flows beyond the matrix, momenta there, and the matrix
        def at(s):
            n = np.array([[1, 2 * np.sin(s)], [0, 1.3]])
            f = n @ u
            p1 = brentq(lambda p: p + p**3 - f[0], -9, 9, xtol=1e-15)
            return f, np.array([p1, 2 * f[1]]), n

        known = {
            "a.f[1]": u[0],
            "b.f[2]": 1.3 * u[1],
            "ma.p[1]": mass[0] @ u,
            "mb.p[2]": 2.6 * u[1],
        }
        return at(known[read])

    def rates(_, u):
        f, _, n = behind(u)
        step = 1e-6
        slope = [(behind(u + d)[1] - behind(u - d)[1]) / (2 * step) for d in step * np.eye(2)]
        return np.linalg.solve(mass + n.T @ np.transpose(slope), [1, -0.5] - n.T @ (0.05 * f))

    start = np.linalg.solve(mass, [0.1, 0.3])
    u = reference(rates, start, result["time"])
    p = np.array([behind(x)[1] for x in u.T]).T
    expected = {f"a.f[{k + 1}]": u[k] for k in range(2)} | {
        f"mb.p[{k + 1}]": p[k] for k in range(2)
    }
    agree(result, expected, tolerance=1e-7)


@pytest.mark.parametrize(
    ("speed", "ratio", "kept"),
    [
        ("sin(time)", "2 + cos(a.f)", ["ma"]),
        ("floor(2*time)", "2 + cos(a.f)", []),
        ("0", "2 + cos(a.f) + floor(time)", []),
    ],
)
def test_a_momentum_is_common_where_sources_or_moduli_jump(speed, ratio, kept, tmp_path):
    """The momentum of one body alone would miss the impulse."""
    text = f"""model M {{ a : J1; ma : I(1); z : J0; b : J1; mb : I(1); s : Sf({speed});
      t : MTF {{ f2 = ({ratio})*f1; }} a -> ma; a -> t -> z; s -> z; z -> b -> mb; }}
    scene q of M {{ observe a.f; run 1 s; }}"""
    path = tmp_path / "jump.bg"
    path.write_text(text)
    program = compile_scene(path, Options(), until="causality").causal
    variables = Variables(program)
    groups = find_groups(variables, storage_elements(program, variables))
    found = [e.storage.name for group in groups for e in elements_on_flows(variables, group)]
    assert found == kept
