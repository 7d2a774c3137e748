"""`bgc.reduced_part`: passive parts of fewer states, against dense computations and runs."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from scipy.linalg import expm

import bgc
from bgc.diagnostics.diagnostic import BgError
from bgc.options import Options
from bgc.resolution.resolve import load
from bgc.runtime.reduced_parts.part_source import read_part
from bgc.runtime.reduced_parts.part_text import PartText
from bgc.runtime.reduced_parts.subspace import static_basis
from bgc.runtime.reduced_parts.terminated import StateSpace

WALL = """
import thermal.heat;
interface HeatPath {
  port a in : Thermal;
  port b out : Thermal main;
  param area : m^2 = 1 m^2 in 0.1 m^2 .. 100 m^2;
  output middle : K;
}
model Layers[n = 40] is HeatPath {
  port a in : Thermal;
  port b out : Thermal main;
  param area : m^2 = 1 m^2 in 0.1 m^2 .. 100 m^2;
  param resistance : K/W = 2.5 K/W in 1e-9 K/W .. 1e9 K/W;
  param capacity : J/K = 300 kJ/K in 1e-9 J/K .. 1e12 J/K;
  for i in 1..n {
    inner[i] : Conductor(conductance = 2*n*area/(1 m^2)/resistance);
    outer[i] : Conductor(conductance = 2*n*area/(1 m^2)/resistance);
    node[i]  : J0;
    store[i] : HeatCapacity(capacity = capacity*area/(1 m^2)/n, temperature0 = 263.15 K);
    inner[i] -> node[i] -> store[i], outer[i];
  }
  for i in 2..n { outer[i - 1] -> inner[i]; }
  a -> inner[1];
  outer[n] -> b;
  output middle : K = node[n/2].e;
}
model House {
  room    : Se(e = 293.15 K);
  inside  : Conductor(conductance = 8 W/K);
  wall    : HeatPath(area = 2 m^2) = Layers;
  outside : Conductor(conductance = 25 W/K);
  air     : FixedTemperature(temperature = 263.15 K);
  room -> inside -> wall -> outside -> air;
}
scene house of House { observe inside.heat_flow as loss, wall.middle; run 120 h every 1 h; }
"""

# A planar cantilever of n rigid segments, with springs and dampers across and about its joints.
BEAM = """
domain Push { effort F : N; flow v : m/s; }
interface Tip { port tip in : Push; }
model Cantilever[n = 12] is Tip {
  port tip in : Push;
  param L = 3; param EI = 1e5; param rho = 20; param damping = 2e-4;
  let h = L/n;
  for i in 1..n {
    trans[i] : J1; mass[i] : I(rho*h); trans[i] -> mass[i];
    rot[i] : J1; inertia[i] : I(rho*h^3/12); rot[i] -> inertia[i];
    across[i] : J0; js[i] : J1; shear[i] : C(stiffness = 12*EI/h^3);
    drag[i] : R(resistance = damping*12*EI/h^3); across[i] -> js[i] -> shear[i], drag[i];
    about[i] : J0; jr[i] : J1; bend[i] : C(stiffness = EI/h);
    loss[i] : R(resistance = damping*EI/h); about[i] -> jr[i] -> bend[i], loss[i];
    arm[i] : TF(ratio = h/2);
    across[i] -> trans[i]; about[i] -> rot[i]; rot[i] -> arm[i] -> across[i];
  }
  for i in 2..n {
    back[i] : TF(ratio = h/2);
    trans[i - 1] -> across[i]; rot[i - 1] -> back[i] -> across[i]; rot[i - 1] -> about[i];
  }
  end : J0; lever : TF(ratio = 2/h);
  tip -> end -> trans[n]; end -> lever -> rot[n];
}
model Bench { push : Se(100); beam : Tip = Cantilever; push -> beam; }
scene bench of Bench { observe beam.tip.v; run 1 s; }
"""

# Resistors between states and inputs, a gyrator, inertias on one gear, a constant source.
MIXED = """
domain Wire { effort u : V; flow i : A; }
domain Push { effort F : N; flow v : m/s; }
interface Box { port a in : Wire; port b out : Push main; output both[2]; }
model Mixed is Box {
  port a in : Wire; port b out : Push main;
  n1 : J0; a -> n1;
  s1 : J1; r1 : R(2 ohm); l1 : I(0.3 H); n1 -> s1; s1 -> r1, l1;
  s2 : J1; r2 : R(3 ohm); c2 : C(0.2 F, e0 = 0.4 V); n1 -> s2; s2 -> r2, c2;
  s3 : J1; l3 : I(0.1 H); motor : GY(ratio = 1.7 N/A); n1 -> s3; s3 -> l3; s3 -> motor -> shaft;
  shaft : J1; m1 : I(2 kg); d1 : R { e = 8 N * sinh(0.05*f/(1 m/s)); } shaft -> m1, d1;
  weight : Se(e = 3 N); weight -> shaft;
  gear : TF(ratio = 0.5); shaft -> gear -> second;
  second : J1; m2 : I(1.5 kg); second -> m2;
  gap : J0; k : C(stiffness = 40 N/m); second -> gap -> k; gap -> b;
  output both[2] = [l3.f + 2*a.u/(1 V), k.q];
}
model Bench {
  va : Se(e = 1 V); ra : R(0.7 ohm); ja : J1; va -> ja -> ra;
  box : Box = Mixed; ja -> box;
  out : J1; load : R(5 N*s/m); mass : I(0.8 kg); box -> out -> load, mass;
}
scene bench of Bench { observe ja.f, out.f, box.both; run 0.5 s every 10 ms; }
"""


def written(folder: Path, text: str) -> Path:
    path = folder / "model.bg"
    path.write_text(text)
    return path


def test_a_wall_is_passive_and_has_its_static_gain_and_start(tmp_path: Path) -> None:
    path = written(tmp_path, WALL)
    for states, step in ((2, 0.3), (4, 1e-2), (6, 1e-3)):
        part = bgc.reduced_part(path, "wall", states)
        assert (part.whole.states, part.reduced.states) == (40, states)
        assert part.error.step < step
        links, losses = part.reduced.interconnection, part.reduced.dissipation
        assert (links == -links.T).all()
        assert np.linalg.eigvalsh(losses)[0] >= 0
        for w in np.geomspace(1e-8, 1, 30):
            response = part.reduced.response(1j * w)
            assert np.linalg.eigvalsh(response + response.conj().T)[0] > -1e-12
    # Steady heat of 1 W through the wall: 2.5/2 K at the ends, which the text gives.
    u = np.array([1.0, -1.0])
    for system in (part.whole, part.reduced):
        x = np.linalg.lstsq(system.A, -system.B @ u, rcond=None)[0]
        warm, cold = system.C @ x + system.D @ u
        assert warm - cold == pytest.approx(1.25, rel=1e-9)
    middle = part.reduced.outputs[0, :-3] @ part.reduced.start
    assert middle == pytest.approx(263.15, rel=1e-12)
    assert "param area : m^2 = 2.0;" in part.text


def test_a_reduced_wall_fills_the_slot_of_the_whole_one(tmp_path: Path) -> None:
    path = written(tmp_path, WALL)
    part = bgc.reduced_part(path, "wall", 6, name="Slim")
    small = tmp_path / "small.bg"
    part.to_bg(small)
    scene = "scene small is house { use wall = Slim; observe energy.stored; }"
    small.write_text(small.read_text() + scene)
    one = bgc.compile(path).simulate(rtol=1e-8)
    two = bgc.compile(small).simulate(rtol=1e-8)
    assert np.abs(one["loss"] - two["loss"])[1:].max() < 1.2e-2 * one["loss"][0]
    assert np.abs(one["wall.middle"] - two["wall.middle"]).max() < 0.4
    assert not two["energy.stored"].any()  # heat is no power
    with pytest.raises(BgError, match=r"BG705.*reduced for its area"):
        bgc.compile(small).simulate(parameters={"wall.area": 3.0})


@pytest.mark.parametrize(("states", "error"), [(2, 0.04), (4, 5e-3), (8, 1e-3)])
def test_a_clamped_beam_deflects_as_the_whole_one(
    tmp_path: Path, states: int, error: float
) -> None:
    part = bgc.reduced_part(written(tmp_path, BEAM), "beam", states)
    assert part.whole.states == 48
    times = np.linspace(0, 1.0, 400)

    def deflection(system: StateSpace) -> np.ndarray:
        n = len(system.A)
        rates = np.block([[system.A, system.B, np.zeros((n, 1))], [np.zeros((1, n + 2))],
                          [system.C, system.D, np.zeros((1, 1))]])  # fmt: skip
        onward, state = expm(rates * times[1]), np.zeros(n + 2)
        state[n] = 1.0
        found = []
        for _ in times:
            found.append(state[-1])
            state = onward @ state
        return np.array(found)

    whole, reduced = (
        deflection(StateSpace(s.A, s.B, s.C, s.D)) for s in (part.whole, part.reduced)
    )
    assert np.abs(whole - reduced).max() < error * np.abs(whole).max()
    # Static deflection of the springs in series, each with its lever arm.
    h, EI = 3 / 12, 1e5
    arms = 3 - h * np.arange(12)
    static = (arms**2 * h / EI + h**3 / (12 * EI)).sum()
    slope = np.linalg.solve(part.reduced.A, part.reduced.B)
    compliance = -(part.reduced.C @ np.linalg.solve(part.reduced.A, slope))[0, 0]
    assert compliance == pytest.approx(static, rel=1e-6)


def test_a_part_of_all_kinds_of_elements_is_written_again_exactly(tmp_path: Path) -> None:
    """All states kept, the text gives the same motion as the part itself."""
    path = written(tmp_path, MIXED)
    source = read_part(path, Options(), load(path), "box", {})
    system = source.found.system
    assert system.states == 5  # six stores, two of which turn together
    assert np.abs(system.dissipation[:5, 5:]).max() > 0.1
    assert source.tangents == ("box.d1",)
    text = PartText("Same", "", source.base, source.ports, (), source.outputs, system.sparse())
    same = tmp_path / "same.bg"
    scene = "scene same is bench { use box = Same; }"
    same.write_text(f'import "model.bg";\n{text.text()}{scene}')
    one, two = (bgc.compile(each).simulate(rtol=1e-9) for each in (path, same))
    for name in ("ja.f", "out.f", "box.both[1]", "box.both[2]"):
        assert two[name] == pytest.approx(one[name], abs=2e-4)  # sinh f is nearly f


def test_the_h_infinity_norm_of_a_resonance() -> None:
    """1/(s^2 + 2 z s + 1) has the peak 1/(2 z sqrt(1 - z^2))."""
    z = 1e-3
    A = np.array([[0.0, 1.0], [-1.0, -2 * z]])
    system = StateSpace(A, np.array([[0.0], [1.0]]), np.array([[1.0, 0.0]]), np.zeros((1, 1)))
    assert system.h_infinity() == pytest.approx(1 / (2 * z * np.sqrt(1 - z**2)), rel=2e-4)
    assert system.h2() == pytest.approx(np.sqrt(1 / (4 * z)), rel=1e-9)


def test_steady_states_of_a_part_span_its_least_states(tmp_path: Path) -> None:
    path = written(tmp_path, WALL)
    system = read_part(path, Options(), load(path), "wall", {}).found.system
    assert static_basis(system).shape == (40, 2)
    with pytest.raises(BgError, match=r"BG665.*steady states need 2"):
        bgc.reduced_part(path, "wall", 1)


@pytest.mark.parametrize(
    ("part", "reason"),
    [
        ("none", "no such part; it has `room`"),
        ("bent", "depends on more than its own variables"),
        ("alone", "no ports"),
        ("own", "states, unknowns or samples"),
    ],
)
def test_parts_that_cannot_be_reduced_say_why(tmp_path: Path, part: str, reason: str) -> None:
    text = """
    model Bent { port p in; j : J1; c : C(1); r : MR { e = (1 + sin(time))*f; } p -> j -> c, r; }
    model Alone { s : Se(1); j : J1; c : C(1); s -> j -> c; output e = c.e; }
    model Own { port p in; state x; der(x) = 1 - x; r : R(1); p -> r; output y = x; }
    model M {
      room : Alone; alone : Alone; j : J1; s : Se(1); bent : Bent; own : Own;
      s -> j -> bent, own;
    }
    scene m of M { observe j.f; run 1 s; }
    """
    with pytest.raises(BgError, match=reason):
        bgc.reduced_part(written(tmp_path, text), part, 2)
