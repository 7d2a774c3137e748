"""Parameters of a run that make a symmetric storage matrix asymmetric are refused (BG445)."""

import model_files
import numpy as np
import pytest
from refusals import refusal

import bgc
from bgc.diagnostics.diagnostic import Severity
from bgc.runtime.running.binding import text

FREE = (
    "model M {{ {body} j1 : J1; j2 : J1; j1, j2 -> x; j1, j2 -> m; "
    "m : I[2]([4, 5], f0 = [1, 2]); }}"
)
SCENE = " scene s of M { observe m.f, energy.residual; run 1 s; }"
BEAM = "param G[2,2] = [[3, 1], [1, 2]]; x : C[2](stiffness = G);"
MERGED = "param G[2,2] = [[3, 1], [1, 2]]; x : I[2](G);"
MESSAGE = (
    "the matrix of `x` must be symmetric: its entries [1, 2] and [2, 1] differ, "
    "by `G[1,2]` and `G[2,1]`"
)


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    return tmp_path_factory.mktemp("symmetry")


def compiled(folder, body, scene=SCENE):
    return model_files.compiled(folder, FREE.format(body=body) + scene)


def checks_of(model):
    table = model.library.model
    return [text(table.param_check[k]) for k in range(table.n_check)]


def refused(model, **changes):
    return refusal(model.simulate, **changes)


@pytest.mark.parametrize("body", [BEAM, MERGED])
def test_one_entry_alone_is_refused_and_both_are_accepted(folder, body):
    for _ in range(2):  # the second model comes from the cache
        model = compiled(folder, body)
        found = refused(model, parameters={"G[1,2]": 1.5})
        assert (found.code, found.severity, found.message) == ("BG445", Severity.ERROR, MESSAGE)
        assert found.span is not None and found.span.text.startswith("x")
    model.parameters["G[1,2]"] = 1.5
    assert refused(model).code == "BG445"
    model.parameters["G[2,1]"] = 1.5
    result = model.simulate()
    assert np.max(np.abs(result["energy.residual"])) < 1e-4
    model.parameters["G"] = [[3, 0.7], [0.7 + 1e-13, 2]]  # rounding
    model.simulate()


def test_the_energy_of_a_nearly_symmetric_matrix_is_integrated(folder):
    body = "x : C[2](stiffness = [[3, 1], [1.004, 2]]);"
    model = compiled(folder, body)
    assert np.max(np.abs(model.simulate()["energy.residual"])) < 1e-4


def test_a_field_of_many_ports_uses_both_mirrored_entries(folder):
    size = 9
    basis = np.random.default_rng(4).normal(size=(size, size)) * np.logspace(0, -1, size)[:, None]
    matrix = basis.T @ basis
    rows = ", ".join("[" + ", ".join(map(repr, row.tolist())) + "]" for row in matrix)
    path = folder / "field.bg"
    path.write_text(
        f"model M {{ param L[{size},{size}] = [{rows}];"
        f" supply : Se[{size}](e = 1); all : J1[{size}];"
        f" coils : I[{size}](L); loss : R[{size}](0.5); supply -> all -> coils, loss; }}"
        " scene s of M { observe coils.f as f, energy.residual; run 1 s every 0.5 s; }",
        encoding="utf-8",
    )
    model = bgc.compile(path)
    assert "`L[9,2]`" in refused(model, parameters={"L[9,2]": matrix[8, 1] + 0.1}).message
    for factor in (1.0, 2.0):
        result = model.simulate(
            parameters={"L": (factor * matrix).tolist()}, rtol=1e-10, atol=1e-12
        )
        rates, modes = np.linalg.eigh(factor * matrix)
        rise = (1 - np.exp(-0.5 / rates)) / 0.5
        expected = modes @ (rise * (modes.T @ np.ones(size)))
        found = [result[f"f[{k + 1}]"][-1] for k in range(size)]
        assert np.abs(found - expected).max() < 1e-8 * np.abs(expected).max()
        assert np.abs(result["energy.residual"]).max() < 1e-8


def test_an_ensemble_refuses_the_members_that_are_asymmetric(folder):
    model = compiled(folder, BEAM)
    entries = {"G[1,2]": [1.0, 1.5, 1.5], "G[2,1]": [1.0, 1.0, 1.5]}
    many = model.simulate_many(parameters=entries)
    assert {k: d.code for k, d in many.failures.items()} == {1: "BG445"}


def test_only_what_parameters_can_make_asymmetric_is_checked(folder):
    bodies = {
        "one parameter": "param g = 1; x : C[2](stiffness = [[3, g], [g, 2]]);",
        "proven": "param g = 1; x : C[2](stiffness = [[3, (g + 1)^2], [g^2 + 2*g + 1, 2]]);",
        "constant": "param g = 3; x : C[2](stiffness = [[g, 1], [1, 2]]);",
        "asymmetric": "param G[2,2] = [[3, 1.2], [1.1, 2]]; x : C[2](stiffness = G);",
        "resistor": "param G[2,2] = [[3, 1.2], [1.2, 2]]; x : R[2](G);",
    }
    for name, body in bodies.items():
        model = compiled(folder, body)
        first = next(iter(model.parameters))
        assert not any("must be symmetric" in message for message in checks_of(model)), name
        changed = {"G[1,2]": 1.3} if "G[1,2]" in model.parameters else {first: 1.3}
        model.simulate(parameters=changed)
        assert any(d.code == "BG445" for d in model.warnings) == (name == "asymmetric")


def test_an_entry_that_is_undefined_is_named_as_such(folder):
    body = "param a = 2; param b = 2; x : C[2](stiffness = [[3, 1/a], [1/b, 2]]);"
    model = compiled(folder, body)
    found = refused(model, parameters={"a": 0})
    assert found.code == "BG707" and "`a`" in found.message
    assert "by `a` and `b`" in refused(model, parameters={"a": 3}).message


def test_a_part_that_the_scene_does_not_need_is_not_checked(folder):
    body = BEAM + " state y = 0; der(y) = 1;"
    model = compiled(folder, body, " scene s of M { observe y; run 1 s; }")
    assert not checks_of(model)
