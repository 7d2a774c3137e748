"""Signals that are given component by component, in any order, and as parameters of parts."""

import numpy as np

import bgc

TEXT = """
model Part { param v[2]; param one; state z = v[2]; der(z) = -v[1]*z; }
model Whole {
  param k = 2;
  state y = 1;
  der(y) = -y;
  signal chain[400];
  chain[400] = k*y;
  for i in 1..399 { chain[i] = chain[i + 1] + 1; }
  signal c[3];
  let b = c[1] + 1;
  c[2] = b*c.x;
  c[1] = y^2;
  c[3] = c.y*jacobian(c[2], y);
  output m[2, 2];
  m[2, 1] = m[1, 2] + 1; m[1, 2] = m[1, 1] + 1; m[1, 1] = y; m[2, 2] = m[2, 1] + m[1, 2];
  signal w[2];
  w[1] = 3*k;
  w[2] = w[1] + 1;
  signal one;
  one = k - 1;
  p : Part(v = w, one = one);
}
scene s of Whole { observe chain[1] as chain, c, m, p.z, p.one as one; run 1 s every 0.5 s; }
"""


def test_components_depend_on_each_other_in_any_order(tmp_path):
    path = tmp_path / "a.bg"
    path.write_text(TEXT)
    model = bgc.compile(path, preview=True)
    result = model.simulate(rtol=1e-9, parameters={"k": 3})
    y = np.exp(-result.time)
    np.testing.assert_allclose(result["chain"], 3 * y + 399, rtol=1e-7)
    c2 = (y**2 + 1) * y**2
    np.testing.assert_allclose(result["c"], np.transpose([y**2, c2, c2 * (4 * y**3 + 2 * y)]), 1e-6)
    np.testing.assert_allclose(result["m[2,2]"], 2 * y + 3, rtol=1e-7)
    np.testing.assert_allclose(result["p.z"], 10 * np.exp(-9 * result.time), rtol=1e-6)
    assert result["one"][0] == 2
