"""Passive laws pass, and the eigenvalues of fields are those of numpy.

The warnings of scalar laws stand in `wrong/laws_that_supply_power.txt`.
"""

import re
from pathlib import Path

import numpy as np
import pytest

from bgc.diagnostics.diagnostic import Diagnostic, Severity
from bgc.elaboration.elaborate import elaborate
from bgc.ir.defaults import default_values
from bgc.passivity.passive_laws import check_physics
from bgc.resolution.resolve import load, load_text

ROOT = Path(__file__).parents[2]
MODELS = ROOT / "tests" / "models"


def warnings_of(element: str, width: int = 1) -> tuple[Diagnostic, ...]:
    """The warnings about one element on a junction."""
    text = (
        f"model M {{ node : J1; load : Se[{width}](e = zeros({width})); x : {element}"
        " load -> node -> x; } scene s of M { observe x.e; run 1 s; }"
    )
    found = check_physics(elaborate(load_text(text, "odd.bg")))
    assert all(d.severity is Severity.WARNING and d.help and d.span for d in found)
    return found


@pytest.mark.parametrize(
    ("element", "message"),
    [
        ("I(-2);", "the inertia of `x` is negative: -2"),
        ("C(-1e-6);", "the compliance of `x` is negative: -1e-06"),
    ],
)
def test_what_the_equations_refuse_is_named(element, message):
    (found,) = warnings_of(element)
    assert (found.code, found.message) == ("BG460", message)


@pytest.mark.parametrize(
    "element",
    [
        "R(0);",
        "C(stiffness = 0);",
        "R { e = 3*abs(f)*f; }",
        "R { f = 1e-12*(exp(e/0.026) - 1); }",
        "R { e = if f > 0 then 2*f else 300*f; }",
        "MR { e = sign(f)*(3 + time); }",
        "C { H = 2*(q^2 - 1)^2; }",
        "C { e = q^3 - q; }",
        "I { f = p + p^3; }",
        "I { H = 5*sqrt(1 + p^2); }",
        "IC { H = p^2/(2*(1 + q^2)) - 9*cos(q); }",
    ],
)
def test_passive_laws_pass(element):
    assert warnings_of(element) == ()


def test_powers_that_overflow_to_both_sides_decide_nothing():
    """The coupling alone takes and gives more than a double holds, and no power in total."""
    law = "R[2] { f[1] = e[1] + sinh(e[1] - e[2]); f[2] = e[2] - sinh(e[1] - e[2]); }"
    assert warnings_of(law, width=2) == ()


def test_fields_are_told_by_eigenvalue_direction_and_entries():
    (found,) = warnings_of("R[2]([[1, 6], [2, 4]]);", 2)
    eigenvalues, vectors = np.linalg.eigh([[1, 4], [4, 4]])
    along = vectors[:, 0] / vectors[:, 0][np.argmax(np.abs(vectors[:, 0]))]
    assert found.code == "BG462"
    assert f"the eigenvalue {eigenvalues[0]:.6g} along" in found.message
    assert f"f[1] = {along[0]:.3g}, f[2] = {along[1]:.3g}" in found.message
    assert found.note == "its entry [1, 2] is 4, where [1, 1] and [2, 2] allow 2 at most"


@pytest.mark.parametrize(
    ("element", "code"),
    [
        ("I[2]([[1, 1], [1, 1]]);", "BG461"),  # singular
        ("C[2](stiffness = [[1, 1], [1, 1]]);", None),
        ("I[2]([[2, 1], [1 + 1e-15, 2]]);", None),
        ("C[2] { e = [q[1] + q[2]^2, 2*q[1]*q[2]]; }", None),
        ("R[2]([[1, 9], [-9, 0]]);", None),
        ("R[2] { e = [f[1]^3 - 9*f[2], 9*f[1]]; }", None),
    ],
)
def test_fields(element, code):
    assert [d.code for d in warnings_of(element, 2)] == ([code] if code else [])


def test_pseudo_domains_have_no_power_to_check():
    text = (
        "pseudo domain Heat { effort T : K; flow Q : W; }"
        "model Wall { port p in : Heat; r : R { f = 3 W/K^2 * e^2; } p -> r; }"
        "model M { hot : Se(e = 300 K); wall : Wall; hot -> wall; }"
        "scene s of M { observe wall.r.f; run 1 s; }"
    )
    assert check_physics(elaborate(load_text(text))) == ()


# --- vessels --------------------------------------------------------------------------


def damping_of(graph) -> np.ndarray:
    values = default_values(graph.dag, graph.parameters)
    numbers = [
        values[symbol]
        for p in graph.parameters
        if p.name.startswith("ship.D[")
        and (symbol := graph.dag.symbol_of(graph.dag.symbol(0, p.index)))
    ]
    return np.reshape(numbers, (6, 6))


@pytest.mark.parametrize(("scene", "count"), [("afloat", 1), ("potential_alone", 3)])
def test_the_published_damping_of_gunnerus_is_active(scene, count):
    graph = elaborate(load(MODELS / "gunnerus.bg"), scene)
    (found,) = check_physics(graph)
    eigenvalues, vectors = np.linalg.eigh(damping_of(graph))
    assert (eigenvalues < 0).sum() == count
    assert found.code == "BG462" and "`ship.damping` supplies power" in found.message
    assert f"{eigenvalues[0]:.6g} along" in found.message
    ned = np.array([1, -1, -1, 1, -1, -1])
    along = ned * vectors[:, 0]
    along /= along[np.argmax(np.abs(along))]
    told = {int(k): float(x) for k, x in re.findall(r"f\[(\d)\] = ([-.\d]+)", found.message)}
    np.testing.assert_allclose([told.get(k, 0) for k in range(1, 7)], along, atol=1e-3)
    assert ("3 negative eigenvalues" in found.message) == (count == 3)


def test_gunnerus_is_active_in_heave_with_pitch():
    (found,) = check_physics(elaborate(load(MODELS / "gunnerus.bg")))
    assert "the eigenvalue -3781.44 along f[3] = 1, f[5] = 0.0831" in found.message
    assert found.note == "its entry [3, 5] is -68400, where [3, 3] and [5, 5] allow 39464.3 at most"


@pytest.mark.parametrize("name", ["vessel_at_rest", "crane_locks", "rigid_chain", "handle"])
def test_parts_of_the_library_pass(name):
    package = load(MODELS / f"{name}.bg")
    for scene in package.scene_names:
        assert check_physics(elaborate(package, scene)) == ()
