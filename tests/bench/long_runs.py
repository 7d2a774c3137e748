"""Drift over 1,000 s of the crane of `crane.bg`: the gaps of its joints, its energies.

Rules: the scene `long`, drives swinging all the time, springs critically damped and unloaded at the
start, deflections that follow the poses with a lag of 1 s. The gap is by how much the places of two
bodies and the deflection between them have drifted apart, the energy residual is that of the
accounts over the largest of them; of both, the largest of 200 rows. `rodas5p` at its default
tolerance, `ros34prw` at 1 ms.
"""

from __future__ import annotations

import numpy as np
from crane import HERE
from kernels import STIFFNESSES
from table import Row

import bgc

_GAP, _RESIDUAL = 1e-7, 1e-6  # m; of the largest account
_METHODS = (("rodas5p", None), ("ros34prw", 1e-3))


def rows() -> list[Row]:
    """Ratios of what was found to what is allowed."""
    model = bgc.compile(HERE / "crane.bg", scene="long")
    found: list[Row] = []
    for solver, step in _METHODS:
        gaps, residuals = [], []
        for stiffness in STIFFNESSES:
            run = model.simulate(
                solver=solver, step=step, parameters={"stiffness": stiffness}, error=False
            )
            gaps.append(max(float(run[f"{joint}_gap"].max()) for joint in ("slew", "luff", "fold")))
            residual = float(np.abs(run["energy.residual"]).max())
            residuals.append(residual / run.counts["exchanged"])
        for what, values, allowed in (
            ("gap", gaps, _GAP),
            ("energy residual", residuals, _RESIDUAL),
        ):
            each = zip(values, STIFFNESSES, strict=True)
            note = ", ".join(f"{value:.1e} at {k:.0e}" for value, k in each)
            on = f"{what} after 1,000 s / {allowed:g}, {solver}"
            found.append(Row("itself", on, max(values) / allowed, 1, None, True, note))
    return found
