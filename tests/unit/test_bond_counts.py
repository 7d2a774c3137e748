"""Each element with each number of bonds on each side: compiled, or refused with a code.

The cases are made from the table of elements, so that a new element is among them.
"""

from itertools import product
from pathlib import Path

import pytest

from bgc.diagnostics.diagnostic import BgError
from bgc.driver import compile_scene
from bgc.language.elements import ELEMENTS
from bgc.options import Options
from bgc.resolution.resolve import load_text

COUNTS = range(4)  # bonds on a side
# Ways to give the law of each element, with units and without.
LAWS = {
    "Se": ["(e = 5)", "(e = 5 N)", "{ e = 5; }", "[2](e = 5 N)"],
    "Sf": ["(f = 5)", "(f = 5 m/s)", "{ f = 5; }", "[2](f = 5 m/s)"],
    "C": ["(2)", "(stiffness = 2 N/m)", "{ e = q^3 + q; }", "{ H = q^2; }", "[2](2)"],
    "I": ["(2)", "(2 kg)", "{ f = p^3 + p; }", "{ H = p^2; }", "[2](2)"],
    "R": ["(2)", "(2 N*s/m)", "(conductance = 2)", "{ e = f^3 + f; }", "[2](2)"],
    "IC": ["{ H = p^2 + q^2; }", "[2] { H = p[1]^2 + q[2]^2; }"],
    "TF": ["(2)", "(2 m)", "{ f2 = 2*f1; }", "{ e1 = 2 m*e2; }", "[2](2)", "([[1, 2], [3, 4]])"],
    "GY": ["(2)", "(2 N*s/m)", "{ e2 = 2*f1; }", "{ e = [[0, 1], [-1, 0]]*f; }",
           "([[1 N*s/m, 2 N*s/m], [3 N*s/m, 4 N*s/m]])", "[2](2 ohm)"],
    "J0": ["", "[2]"],
    "J1": ["", "[2]"],
    "Mux": ["[1, 1]", "[1, 2]", "[1]"],
    "Demux": ["[1, 1]", "[1, 2]", "[1]"],
}  # fmt: skip
SIDES = {"Mux": ("in", "out"), "Demux": ("in", "out")}


def model(kind: str, law: str, into: int, out: int, neighbour: str) -> str:
    """A model with one element, and sources or resistors at its bonds."""
    parts = [f"a{k} : {neighbour};" for k in range(into)] + [f"b{k} : R(3);" for k in range(out)]
    bonds = [f"a{k} -> x;" for k in range(into)] + [f"x -> b{k};" for k in range(out)]
    return f"model M {{ x : {kind}{law}; {' '.join(parts)} {' '.join(bonds)} }}"


def outcome(text: str) -> list[str]:
    """The codes of the errors; none for a model that compiles to C."""
    try:
        package = load_text(text, "m.bg")
        compile_scene(Path("m.bg"), Options(), package=package, until="emit")
    except BgError as err:
        return [diagnostic.code for diagnostic in err.diagnostics]
    return []


@pytest.mark.parametrize("kind", list(ELEMENTS))
def test_every_number_of_bonds_compiles_or_has_a_code(kind):
    basic = ELEMENTS[kind].basic if kind not in SIDES else kind
    found = set()
    for law, into, out in product(LAWS[basic], COUNTS, COUNTS):
        for neighbour in ("Se(e = 1)", "Sf(f = 1)"):
            codes = outcome(model(kind, law, into, out, neighbour))
            found.add(not codes)
            assert all(code.startswith("BG") for code in codes)
            if ELEMENTS[kind].sides == ("in", "out") and basic in {"TF", "GY"}:
                sided = (into == 0) != (out == 0)
                gyristor = basic == "GY" and law.startswith("{") and into > 0
                assert ("BG443" in codes) == (sided and not gyristor), (law, into, out, codes)
    assert found == {True, False} or basic in {"J0", "J1"}


@pytest.mark.parametrize("law", ["(2 ohm)", "(2)", "([[2 ohm]])", "", "(e = 2 ohm)"])
def test_a_gyrator_with_one_bond_names_the_missing_one(law):
    assert outcome(f"model M {{ s : Se(e = 5 V); x : GY{law}; s -> x; }}") == ["BG443"]
