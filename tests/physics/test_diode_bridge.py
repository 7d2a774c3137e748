"""A three-phase bridge of diodes: one coil's current swings the voltage of its node by 700 V.

The currents of the coils have to pass through diodes of which two conduct 100 A and two block. The
voltage of a diode beside a node with hardly a current is known to 1e-10 V then, as the difference
of large currents over a small slope, and Newton's method cannot find it better.
"""

import numpy as np
from scipy.integrate import solve_ivp
from scipy.optimize import brentq

import bgc

BRIDGE = """
model Bridge {
  param L = 1 mH; param r = 0.2 ohm; param C = 500 uF; param load = 30 ohm;
  param saturation = 1e-6 A; param slope = 0.05 V; param leak = 10 uA/V;
  plus : J0; minus : J0;
  for k in 1..3 {
    phase[k] : Se(e = 325 V * sin(100*pi*time/1 s - 2*pi*(k - 1)/3));
    line[k] : J1; coil[k] : I(L); wire[k] : R(r); node[k] : J0;
    phase[k] -> line[k] -> node[k]; line[k] -> coil[k], wire[k];
    above[k] : J1; upper[k] : R { f = saturation*(exp(e/slope) - 1) + leak*e; }
    below[k] : J1; lower[k] : R { f = saturation*(exp(e/slope) - 1) + leak*e; }
    node[k] -> above[k] -> plus; above[k] -> upper[k];
    minus -> below[k] -> node[k]; below[k] -> lower[k];
  }
  across : J1; smoothed : J0; capacitor : C(C); burden : R(load);
  plus -> across -> minus; across -> smoothed -> capacitor, burden;
}
scene s of Bridge {
  observe smoothed.e as voltage, line[1].f as current;
  run 6 ms every 0.1 ms;
}
"""


def test_a_bridge_runs_at_a_tolerance_near_its_rounding(tmp_path):
    path = tmp_path / "bridge.bg"
    path.write_text(BRIDGE, encoding="utf-8")
    result = bgc.compile(path, preview=True).simulate(rtol=2e-9)
    voltage, current = reference(result.time)
    np.testing.assert_allclose(result["voltage"], voltage, atol=1e-6 * voltage.max())
    np.testing.assert_allclose(result["current"], current, atol=1e-6 * np.abs(current).max())


def reference(times):
    """Voltage of the capacitor and current of the first coil, by LSODA; nodes by bisection."""

    def diode(e):
        return 1e-6 * (np.exp(np.minimum(e / 0.05, 60.0)) - 1) + 1e-5 * e

    def rate(t, state):
        currents, u = np.array([*state[:2], -state[0] - state[1]]), state[2]
        nodes = [
            brentq(lambda v, i=i: diode(v - u) - diode(-v) - i, -5, u + 5, xtol=1e-13)
            for i in currents
        ]
        drops = (
            325 * np.sin(100 * np.pi * t - 2 * np.pi * np.arange(3) / 3) - 0.2 * currents - nodes
        )
        drops -= drops.mean()  # nothing joins the bridge to the star point of the sources
        through = sum(diode(v - u) for v in nodes)
        return [*drops[:2] / 1e-3, (through - u / 30) / 500e-6]

    solved = solve_ivp(rate, (0, times[-1]), np.zeros(3), "LSODA", times, rtol=1e-9, atol=1e-8).y
    return solved[2], solved[0]
