"""Reference values of the problems here that no test set publishes, by two methods each.

    python tests/models/ivp/references.py

The equations are written here a second time, in NumPy. SciPy's DOP853 (or Radau, where it is stiff)
at its tightest goes from one discontinuity to the next; the other is LSODA, or the closed form. It
prints by how much both differ and puts the closed form or the former into `references.json`.
"""

from __future__ import annotations

import json
from collections.abc import Callable
from itertools import pairwise
from pathlib import Path

import numpy as np
import numpy.typing as npt
from scipy.integrate import solve_ivp

Array = npt.NDArray[np.float64]
Rates = Callable[[float, Array], "list[float] | Array"]

FILE = Path(__file__).with_name("references.json")
# A stage at a discontinuity belongs to the piece that it comes from.
PIECE = {"middle": 0.0}


def end_of(rates: Rates, start: Array, breaks: list[float], method: str, rtol: float) -> Array:
    """The state at the last of the breaks, from the first."""
    y = np.array(start, dtype=float)
    for begin, end in pairwise(breaks):
        PIECE["middle"] = 0.5 * (begin + end)
        done = solve_ivp(rates, (begin, end), y, method, rtol=rtol, atol=rtol * 1e-3)
        assert done.success, done.message
        y = done.y[:, -1]
    return y


# --- discontinuities ------------------------------------------------------------------------------


def pushed(_: float, y: Array) -> list[float]:
    push = 1.0 if np.floor(PIECE["middle"]) % 2 == 0 else -1.0
    return [y[1], 0.2 * y[1] - (np.pi**2 + 0.01) * y[0] + push]


def pushed_exactly() -> Array:
    """Oscillations about the rest under each push, multiplied by exp(0.1) in each second."""
    square, y = np.pi**2 + 0.01, np.zeros(2)
    for k in range(20):
        rest = np.array([(-1) ** k / square, 0.0])
        y = rest - np.exp(0.1) * (y - rest)  # half a period: exp(0.1) (cos(pi) + sin(pi) ..)
    return y


def alternating_exactly() -> Array:
    y = 110.0
    for k in range(20):
        rate = 1.5 if k % 2 == 0 else 0.5
        y = 55 / rate + (y - 55 / rate) * np.exp(-rate)
    return np.array([y])


def alternating(_: float, y: Array) -> list[float]:
    return [55 - (1.5 if np.floor(PIECE["middle"]) % 2 == 0 else 0.5) * y[0]]


def kinked(t: float, y: Array) -> list[float]:
    return [y[1], 0.01 * y[1] * (1 - y[0] ** 2) - y[0] - abs(np.sin(np.pi * t))]


def spike(t: float, y: Array) -> list[float]:
    if PIECE["middle"] > 10:
        return [-2 * y[0]]
    return [-2 / 21 - 120 * (t - 5) / (1 + 4 * (t - 5) ** 2) ** 2]


def euler_pulse(t: float, y: Array) -> list[float]:
    pulse = 0.25 * np.sin(t) ** 2 if 3 * np.pi < PIECE["middle"] < 4 * np.pi else 0.0
    return [-y[1] * y[2] / 0.5, 2.5 * y[2] * y[0] / 2, (-1.5 * y[0] * y[1] + pulse) / 3]


# --- smooth ones ----------------------------------------------------------------------------------


def reactor(_: float, y: Array) -> list[float]:
    k = np.exp(20.7 - 1500 / y[0])
    return [
        1.3 * (y[2] - y[0]) + 10400 * k * y[1],
        1880 * (y[3] - y[1] * (1 + k)),
        1752 - 269 * y[2] + 267 * y[0],
        0.1 + 320 * y[1] - 321 * y[3],
    ]


def robertson(_: float, y: Array) -> list[float]:
    slow, fast = -0.04 * y[0] + 1e4 * y[1] * y[2], 3e7 * y[1] ** 2
    return [slow, -slow - fast, fast]


def cusp(_: float, state: Array) -> Array:
    y, a, b = state.reshape(3, 32)
    spread = [32**2 / 144 * (np.roll(x, 1) - 2 * x + np.roll(x, -1)) for x in (y, a, b)]
    u = (y - 0.7) * (y - 1.3)
    v = u / (u + 0.1)
    return np.concatenate((
        -1e4 * (y**3 + a * y + b) + spread[0],
        b + 0.07 * v + spread[1],
        (1 - a**2) * b - a - 0.4 * y + 0.035 * v + spread[2],
    ))  # fmt: skip


PLANETS = np.array([0.954786104043e-3, 0.285583733151e-3, 0.437273164546e-4, 0.517759138449e-4,
                    0.277777777778e-5])  # fmt: skip
PLACES = [3.42947415189, 3.35386959711, 1.35494901715, 6.64145542550, 5.97156957878,
          2.18231499728, 11.2630437207, 14.6952576794, 6.27960525067, -30.1552268759,
          1.65699966404, 1.43785752721, -21.1238353380, 28.4465098142, 15.3882659679]  # fmt: skip
SPEEDS = [-0.557160570446, 0.505696783289, 0.230578543901, -0.415570776342, 0.365682722812,
          0.169143213293, -0.325325669158, 0.189706021964, 0.0877265322780, -0.0240476254170,
          -0.287659532608, -0.117219543175, -0.176860753121, -0.216393453025,
          -0.0148647893090]  # fmt: skip


def five_bodies(_: float, state: Array) -> Array:
    y, v = state.reshape(2, 5, 3)
    near = y / np.linalg.norm(y, axis=1)[:, None] ** 3
    pull = -(1.00000597682 + PLANETS[:, None]) * near
    for i in range(5):
        for j in range(5):
            if i != j:
                apart = y[j] - y[i]
                pull[i] += PLANETS[j] * (apart / np.linalg.norm(apart) ** 3 - near[j])
    return np.concatenate((v.ravel(), 2.95912208286 * pull.ravel()))


def squeezer(_: float, state: Array) -> Array:
    """Accelerations out of the constraints' second derivatives, all by their Jacobian."""
    q, v = state[:7], state[7:]
    m = [0.04325, 0.00365, 0.02373, 0.00706, 0.07050, 0.00706, 0.05498]
    inertia = [2.194e-6, 4.410e-7, 5.255e-6, 5.667e-7, 1.169e-5, 5.667e-7, 1.912e-5]
    s, c = np.sin(q), np.cos(q)
    near, ea, fa = m[1] * 0.0115 * 0.007, 0.02 - 0.01421, 0.02 - 0.01421
    M = np.zeros((7, 7))
    M[1, 1] = m[1] * 0.0115**2 + inertia[1]
    M[0, 1] = M[1, 0] = M[1, 1] - near * c[1]
    M[0, 0] = m[0] * 0.00092**2 + m[1] * 0.007**2 - 2 * near * c[1] + inertia[0] + M[1, 1]
    M[2, 2] = m[2] * (0.01874**2 + 0.01043**2) + inertia[2]
    M[3, 3] = m[3] * ea**2 + inertia[3]
    M[3, 4] = M[4, 3] = M[3, 3] + m[3] * 0.04 * ea * s[3]
    M[4, 4] = M[3, 4] + m[3] * (0.04**2 + 0.04 * ea * s[3])
    M[4, 4] += m[4] * (0.02308**2 + 0.00916**2) + inertia[4]
    M[5, 5] = m[5] * fa**2 + inertia[5]
    M[5, 6] = M[6, 5] = M[5, 5] - m[5] * 0.04 * fa * s[5]
    M[6, 6] = M[5, 6] + m[5] * (0.04**2 - 0.04 * fa * s[5])
    M[6, 6] += m[6] * (0.01228**2 + 0.00449**2) + inertia[6]
    x = 0.02 * c[2] + 0.018 * s[2] - 0.03635 - 0.014
    y = 0.02 * s[2] - 0.018 * c[2] + 0.03273 - 0.072
    force = -4530 * (1 - 0.07785 / np.hypot(x, y))
    f = np.array([
        0.033 - near * v[1] * (v[1] + 2 * v[0]) * s[1],
        near * v[0] ** 2 * s[1],
        force * (x * (0.018 * c[2] - 0.02 * s[2]) + y * (0.02 * c[2] + 0.018 * s[2])),
        m[3] * 0.04 * ea * v[4] ** 2 * c[3],
        -m[3] * 0.04 * ea * v[3] * (v[3] + 2 * v[4]) * c[3],
        -m[5] * 0.04 * fa * v[6] ** 2 * c[5],
        m[5] * 0.04 * fa * v[5] * (v[5] + 2 * v[6]) * c[5],
    ])  # fmt: skip
    # Bars: length, and its angle as a sum of the coordinates and a constant turn, by loop.
    common = [(0.007, (0,), 0.0), (-0.028, (0, 1), 0.0)]
    loops = [
        [*common, (-0.035, (2,), -np.pi / 2)],
        [*common, (-0.02, (3, 4), -np.pi / 2), (-0.04, (4,), 0.0)],
        [*common, (-0.02, (5, 6), 0.0), (-0.04, (6,), -np.pi / 2)],
    ]
    G, bent = np.zeros((6, 7)), np.zeros(6)
    for k, bars in enumerate(loops):
        for length, angles, turn in bars:
            a, rate = q[list(angles)].sum() + turn, v[list(angles)].sum()
            for i in angles:
                G[2 * k : 2 * k + 2, i] += length * np.array([-np.sin(a), np.cos(a)])
            bent[2 * k : 2 * k + 2] -= length * rate**2 * np.array([np.cos(a), np.sin(a)])
    whole = np.block([[M, G.T], [G, np.zeros((6, 6))]])
    return np.concatenate((v, np.linalg.solve(whole, np.concatenate((f, -bent)))[:7]))


SQUEEZED = [-0.0617138900142764, 0, 0.45527981916307, 0.222668390165886, 0.487364979543843,
            -0.222668390165886, 1.23054744454982, *[0.0] * 7]  # fmt: skip
ANGLES = 2 * np.pi * np.arange(1, 33) / 32
CELLS = np.concatenate((np.zeros(32), -2 * np.cos(ANGLES), 2 * np.sin(ANGLES)))
WHOLE = [float(k) for k in range(21)]
PLANET_NAMES = [f"{x}[{i},{k}]" for x in "yv" for i in range(1, 6) for k in (1, 2, 3)]
CELL_NAMES = [f"{x}[{i}]" for x in "yab" for i in range(1, 33)]
SQUEEZER_NAMES = [f"{x}[{i}]" for x in "qv" for i in range(1, 8)]

# name: f, start, breaks, names, method, the other method or the exact values
PROBLEMS = {
    "detest_f1": (pushed, [0, 0], WHOLE, ["y", "v"], "DOP853", pushed_exactly),
    "detest_f2": (alternating, [110], WHOLE, ["y"], "DOP853", alternating_exactly),
    "detest_f3": (kinked, [0, 0], WHOLE, ["y", "v"], "DOP853", "LSODA"),
    "detest_f4": (spike, [1], [0, 10, 20], ["y"], "DOP853",
                  lambda: np.array([np.exp(-20) / 21])),
    "euler_pulse": (euler_pulse, [1, 0, 0.9], [0, 3 * np.pi, 4 * np.pi, 20],
                    [f"y[{k}]" for k in (1, 2, 3)], "DOP853", "LSODA"),
    "reactor": (reactor, [761, 0, 600, 0.1], [0, 1000], [f"y[{k}]" for k in range(1, 5)],
                "Radau", "LSODA"),
    "robertson_dae": (robertson, [1, 0, 0], [0, 4e7], ["y1", "y2", "y3"], "Radau", "LSODA"),
    "cusp": (cusp, CELLS, [0, 1.1], CELL_NAMES, "Radau", "LSODA"),
    "five_bodies": (five_bodies, [*PLACES, *SPEEDS], [0, 20], PLANET_NAMES, "DOP853", "LSODA"),
    "squeezer": (squeezer, SQUEEZED, [0, 0.03], SQUEEZER_NAMES, "DOP853", "Radau"),
}  # fmt: skip


def main() -> None:
    references = json.loads(FILE.read_text())
    for name, (rates, start, breaks, names, method, other) in PROBLEMS.items():
        found = end_of(rates, np.array(start), breaks, method, 1e-12)
        closed = not isinstance(other, str)
        check = other() if closed else end_of(rates, np.array(start), breaks, other, 1e-12)
        apart = (np.abs(found - check) / (np.abs(check) + 1e-6 * np.abs(check).max())).max()
        first, second = ("closed form", method) if closed else (method, other)
        print(f"{name:16}{first}, {second} differs by {apart:.1e}", flush=True)
        references[name] = {
            "source": f"{first}; SciPy's {second} at rtol 1e-12 differs by {apart:.0e}",
            "end": dict(zip(names, map(float, check if closed else found), strict=True)),
        }
    FILE.write_text(json.dumps(references, indent=1) + "\n")


if __name__ == "__main__":
    main()
