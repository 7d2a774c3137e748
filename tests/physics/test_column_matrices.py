"""Transformers whose matrix is one column, which a state turns, between bonds of width 1 and 2."""

import numpy as np
import pytest
from model_files import model_text
from scipy.integrate import solve_ivp

import bgc

SOURCE = model_text("column_matrices")


@pytest.mark.parametrize("transformer", ["MTF[1, 2]", "MTF"])
@pytest.mark.parametrize(
    ("column", "entries"),
    [
        ("[[cos(spring.q/1 m)], [1]]", lambda t, q: (np.cos(q), 1)),
        ("[[2], [spring.q/1 m]]", lambda t, q: (2, q)),
        ("[[1 + spring.q/1 m], [sin(spring.q/1 m)]]", lambda t, q: (1 + q, np.sin(q))),
        ("[[cos(time/1 s)], [spring.q/1 m]]", lambda t, q: (np.cos(t), q)),
    ],
)
def test_a_column_turned_by_a_state(tmp_path, transformer, column, entries):
    path = tmp_path / "m.bg"
    path.write_text(SOURCE.replace("TRANSFORMER", transformer).replace("COLUMN", column))
    result = bgc.compile(path).simulate(rtol=1e-10)

    def rates(t, y):
        place, speed = y
        return [speed, (-place - sum(x**2 for x in entries(t, place)) * speed) / 2]

    exact = solve_ivp(rates, (0, 2), [0.3, 0], t_eval=result.time, rtol=1e-11, atol=1e-13).y
    np.testing.assert_allclose(result["place"], exact[0], rtol=1e-7)
    np.testing.assert_allclose(result["speed"], exact[1], rtol=1e-7, atol=1e-9)


def test_a_written_width_of_one_is_a_vector_in_the_law_and_a_scalar_behind_it(tmp_path):
    """Neither `f1[1]` nor a matrix of entries that read the flow of the bond is refused."""
    law = "[f1[1]*cos(m1.f/1 m/s), 2*f1[1]]"
    matrix = "[[cos(m1.f/1 m/s)], [2]]*f1"
    source = SOURCE.replace("TRANSFORMER", "MTF[1, 2]").replace("sum(m1.f)", "m1.f")
    runs = []
    for k, right in enumerate((law, matrix)):
        path = tmp_path / f"m{k}.bg"
        path.write_text(source.replace("COLUMN*f1", right))
        runs.append(bgc.compile(path).simulate(rtol=1e-10)["speed"])
    np.testing.assert_allclose(runs[0], runs[1], rtol=1e-9, atol=1e-12)


def test_a_scalar_ratio_reads_the_flow_behind_a_column(tmp_path):
    path = tmp_path / "m.bg"
    path.write_text(
        "model M { a : J1[2]; ma : I[2](1 kg, f0 = [1 m/s, 0 m/s]); a -> ma; b : J1; mb : I(1 kg);"
        " b -> mb; lever : MTF[2, 1] { e1 = [[0.8], [1 + 0.1*cos(b.f/1 m/s)]]*e2; }"
        " a -> lever -> b; node : J0[2]; c : C[2](1 m/N); node -> c;"
        " motor : MGY[2, 2](ratio = 2 N*s/m*(2 + cos(b.f/1 m/s))); a -> motor -> node; }"
        "scene s of M { observe b.f as behind; run 1 s; }"
    )
    assert np.isfinite(bgc.compile(path).simulate()["behind"]).all()
