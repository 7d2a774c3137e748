"""Models in text for the tests of formulas, and helpers around them."""

from __future__ import annotations

from pathlib import Path

import sympy

from bgc.options import Options
from bgc.symbolic.symbolic_model import SymbolicModel

RLC = """
model RLC {
  param R = 2 ohm;
  param L = 1 mH;
  param C = 10 uF;
  supply : Se(e = 5 V);
  loop : J1; coil : I(L); capacitor : C(C); resistor : R(R);
  supply -> loop;
  loop -> coil, capacitor, resistor;
}
scene step of RLC { observe capacitor.e, loop.f; run 10 ms; }
"""

# A motor with a gearbox: the rotor and the load are one reduced inertia.
GEARBOX = """
domain Electrical { effort u : V; flow i : A; }
domain Rotational { effort T : N*m; flow w : rad/s; }
model Motor {
  param R = 1 ohm;
  param L = 1 mH;
  param k = 0.05 N*m/A;
  param J = 1e-4 kg*m^2;
  port leads in : Electrical;
  port shaft out : Rotational;
  coil : J1; winding : I(L); resistance : R(R); machine : GY(k);
  rotor : J1; inertia : I(J);
  leads -> coil -> winding, resistance;
  coil -> machine -> rotor -> inertia;
  rotor -> shaft;
}
model Drive {
  param n = 20;
  param Jl = 0.2 kg*m^2;
  param b = 0.1 N*m*s;
  param Ra = 2 ohm;
  supply : Se(e = 12 V);
  motor : Motor(R = Ra);
  gear : TF(ratio = 1/n);
  load : J1; flywheel : I(Jl); bearing : R(b);
  supply -> motor.leads;
  motor.shaft -> gear -> load -> flywheel, bearing;
}
scene s of Drive { observe load.f as speed; run 1 s; }
"""

QUARTER_CAR = """
model QuarterCar {
  param ms = 300 kg;
  param mu = 40 kg;
  param ks = 20 kN/m;
  param kt = 180 kN/m;
  param d = 1.5 kN*s/m;
  road : Sf(f = 0 m/s);
  contact : J0; tyre : C(stiffness = kt);
  axle : J1; wheel : I(mu);
  strut : J0; leg : J1; spring : C(stiffness = ks); damper : R(d);
  chassis : J1; body : I(ms);
  road -> contact -> tyre;
  contact -> axle -> wheel;
  axle -> strut -> leg -> spring, damper;
  strut -> chassis -> body;
}
scene s of QuarterCar { observe chassis.f as v; run 1 s; }
"""

TANKS = """
model Tanks {
  param A1 = 1; param A2 = 2; param c1 = 0.02; param c2 = 0.015; param Q = 0.01;
  state h1 = 0.3;
  state h2 = 0.5;
  der(h1) = (Q - c1*sqrt(h1))/A1;
  der(h2) = (c1*sqrt(h1) - c2*sqrt(h2))/A2;
}
scene s of Tanks { observe h2; run 1 s; }
"""

# Two alike masses between walls: the denominator has a factor for each mode.
TWINS = """
model Twins {
  param m = 2; param k = 50; param kc = 20; param d = 0.3;
  push : Se(e = 1);
  left : J1; right : J1; body1 : I(m); body2 : I(m);
  wall1 : C(stiffness = k); wall2 : C(stiffness = k); r1 : R(d); r2 : R(d);
  between : J0; gap : J1; spring : C(stiffness = kc);
  push -> left -> body1, wall1, r1;
  right -> body2, wall2, r2;
  left -> between -> right;
  between -> gap -> spring;
}
scene s of Twins { observe right.f as v; run 1 s; }
"""


def symbols(text: str) -> tuple[sympy.Symbol, ...]:
    """Plain symbols by their names."""
    return tuple(sympy.Symbol(name) for name in text.split())


def chain(count: int) -> str:
    """Masses in a row, each with its own mass, spring and damper; the last holds on to a wall."""
    lines = ["push : Se(e = 1); wall : Sf(f = 0);", "push -> j1;"]
    for k in range(1, count + 1):
        lines.append(f"param m{k} = {1 + k / 10}; param k{k} = {10 + k}; param d{k} = {k / 10};")
        lines.append(f"j{k} : J1; b{k} : I(m{k}); g{k} : J0; l{k} : J1;")
        lines.append(f"s{k} : C(stiffness = k{k}); r{k} : R(d{k});")
        lines.append(f"j{k} -> b{k}; j{k} -> g{k} -> l{k} -> s{k}, r{k};")
        lines.append(f"g{k} -> {f'j{k + 1}' if k < count else 'wall'};")
    body = "\n  ".join(lines)
    return f"model Chain {{\n  {body}\n}}\nscene s of Chain {{ observe j{count}.f; run 1 s; }}\n"


def symbolic(folder: Path, text: str, inputs=(), outputs=(), scene=None) -> SymbolicModel:
    path = folder / "model.bg"
    path.write_text(text)
    return SymbolicModel(path, Options(scene), inputs, outputs)
