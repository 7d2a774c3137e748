"""Transformers whose matrix is one column, which a state turns, between bonds of width 1 and 2."""

import numpy as np
import pytest
from scipy.integrate import solve_ivp

import bgc

SOURCE = """model Top {
  b1 : J1;
  m1 : I(2 kg);
  spring : C(1 m/N, q0 = 0.3 m);
  b1 -> m1, spring;
  tf : TRANSFORMER { f2 = COLUMN*f1; }
  j9 : J1[2];
  r : R[2](1 N*s/m);
  b1 -> tf -> j9 -> r;
}
scene s of Top { observe sum(m1.f) as speed, sum(spring.q) as place; run 2 s every 0.1 s; }
"""


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
