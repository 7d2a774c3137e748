"""Laws whose slope is infinite at rest start from rest: throttles in algebraic loops."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np
import pytest
from scipy.optimize import brentq

import bgc

# A throttle and a resistance with a root share a gyrator; no state but the loop's.
PAIR = """model Pair { motion : J1; gear : GY(2 V/A); node : J0; motion -> gear -> node;
  first : R { e = 27 V * sign(f) * sqrt(abs(f) / 1 A); } motion -> first;
  second : R { e = 12 V * (f / 0.1 A) / sqrt(1 + abs(f / 0.1 A)); } node -> second;
  feed : Sf(FEED); feed -> node; }
scene s of Pair { observe first.f, first.e, second.f; run 5 s every 0.1 s; }"""
RAMP = "0.26 A * min(time / 1 s, 1)"
SWING = "0.26 A * sin(time / 0.3 s)"


def expected(feed: float) -> float:
    """The flow of the throttle: e = 2 V/A (feed - f2), where 2 V/A f1 is the other effort."""

    def law(f: float) -> float:
        return 120 * f / math.sqrt(1 + abs(f / 0.1))

    def missed(f: float) -> float:
        root = math.copysign(math.sqrt(abs(f)), f)
        small = brentq(lambda x: law(x) - 2 * f, -1e3, 1e3, xtol=1e-18)
        return 27 * root - 2 * (feed - small)

    return brentq(missed, -1, 1, xtol=1e-18)


@pytest.mark.parametrize("solver", ["rodas5p", "rodas4p2", "dopri5"])
@pytest.mark.parametrize("feed", [RAMP, SWING])
def test_a_throttle_in_a_loop_starts_from_rest(feed: str, solver: str, tmp_path: Path) -> None:
    path = tmp_path / "pair.bg"
    path.write_text(PAIR.replace("FEED", feed))
    result = bgc.compile(path, preview=True).simulate(solver=solver)
    given = {RAMP: lambda t: 0.26 * min(t, 1), SWING: lambda t: 0.26 * math.sin(t / 0.3)}[feed]
    flows = [expected(given(t)) for t in result.time]
    largest = np.abs(flows).max()
    assert result["first.f"] == pytest.approx(flows, rel=1e-6, abs=1e-6 * largest)
