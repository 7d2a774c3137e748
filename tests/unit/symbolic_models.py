"""Models in text for the tests of formulas, and helpers around them."""

from __future__ import annotations

from pathlib import Path

import sympy
from model_files import model_text

from bgc.options import Options
from bgc.symbolic.symbolic_model import SymbolicModel

RLC = model_text("symbolic_models_rlc")

# A motor with a gearbox: the rotor and the load are one reduced inertia.
GEARBOX = model_text("symbolic_models_gearbox")

QUARTER_CAR = model_text("symbolic_models_quarter_car")

TANKS = model_text("symbolic_models_tanks")

# Two alike masses between walls: the denominator has a factor for each mode.
TWINS = model_text("symbolic_models_twins")


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
