"""Solve raw equations densely: the reference that generated programs are compared with.

With states x, all other variables z and x' = S z, the rows are 0 = F(x, z, t). The linear ones are
eliminated once, by null spaces: z = Zx x + z0 + N w. Left null vectors of them are constraints on
x alone (dependent storage), whose derivative is a further linear row. The others are solved for w
by Newton's method at each evaluation; where their Jacobian is singular, the derivative of their
left null space along the motion is solved with them (the hidden constraints). So x' is an
ordinary function of x and t, which SciPy integrates.

No causality, no choice of states, no symbolic elimination: nothing is shared with the compiler.
"""

from __future__ import annotations

import itertools
import time
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from dense_rows import IllPosed, NoSolution
from dense_start import Starting


@dataclass
class Trajectory:
    times: np.ndarray
    columns: dict[str, np.ndarray]
    scales: dict[str, float]


class Reference(Starting):
    """The equations of one program, solved and integrated."""

    def run(
        self,
        duration: float,
        count: int,
        *,
        rtol: float = 1e-9,
        method: str = "LSODA",
        most: float = np.inf,
    ) -> Trajectory:
        """Observed values and energy accounts at equal intervals.

        `most` is the processor time after which the run is given up, in seconds.
        """
        with np.errstate(all="ignore"):
            try:
                return self._run(duration, count, rtol, method, most)
            except (OverflowError, ZeroDivisionError) as err:
                raise NoSolution(str(err)) from err

    def _run(
        self, duration: float, count: int, rtol: float, method: str, most: float
    ) -> Trajectory:
        times = np.linspace(0.0, duration, count + 1)
        x = self.start()
        self.solve(x, 0.0)
        x = self._after(x, 0.0)
        y = np.concatenate([x, np.zeros(3)])
        nx, s = self.nx, self.s
        latest = time.process_time() + most

        def slope(t: float, y: np.ndarray) -> np.ndarray:
            if time.process_time() > latest:
                raise NoSolution(f"{most} s reach t = {t:.3g}")
            at = y[:nx]
            z = self.solve(at, t)
            powers = self._powers(at.tolist(), z.tolist(), t)
            return np.concatenate([s @ z, powers])

        # The sizes of states differ by orders of magnitude; a coarse run finds them.
        start_w = self._w
        size = np.maximum(np.abs(y), 1e-9)
        coarse = self._states(slope, y, times, 1e-4, 1e-3 * size, method)
        size = np.abs(coarse).max(axis=0)
        size = np.where(size > 0, size, 1.0)
        self._w = start_w
        states = self._states(slope, y, times, rtol, 1e-3 * rtol * size, method)
        names = [name for name, _, _ in self.raw.observed]
        table = np.empty((len(times), len(names)))
        for k, at in enumerate(times):
            t = float(at) or 1e-12 * duration  # of a slope that begins at 0, the one after it
            z = self.solve(states[k, :nx], t)
            table[k] = self._observed(states[k, :nx].tolist(), z.tolist(), t)
        columns = {name: table[:, n] for n, name in enumerate(names)}
        for n, name in enumerate(("stored", "supplied", "dissipated")):
            columns[f"energy.{name}"] = states[:, nx + n]
        scales = {name: scale for name, _, scale in self.raw.observed}
        return Trajectory(times, columns, scales)

    def _after(self, x: np.ndarray, t: float) -> np.ndarray:
        """The states behind an instant of sampled parts, which all see the values before it."""
        due = [jump for jump in self._jumps if abs(t / jump[0] - round(t / jump[0])) < 1e-9]
        if not due:
            return x
        z, changed = self.solve(x, t), x.copy()
        for _, places, values in due:
            changed[places] = values(x.tolist(), z.tolist(), t)
        return changed

    def _states(
        self,
        slope: Callable[[float, np.ndarray], np.ndarray],
        y: np.ndarray,
        times: np.ndarray,
        rtol: float,
        atol: np.ndarray,
        method: str,
    ) -> np.ndarray:
        """The states at the times, integrated from one break of the sources to the next."""
        from scipy.integrate import solve_ivp

        duration = float(times[-1])
        breaks = {b for b in self.raw.breaks if 0 < b < duration}
        for period, *_ in self._jumps:
            instants = period * np.arange(1, round(duration / period) + 1)
            breaks -= {b for b in breaks if np.abs(instants - b).min(initial=np.inf) < 1e-9}
            breaks |= {float(at) for at in instants if at < duration * (1 - 1e-12)}
        points = [0.0, *_apart(sorted(breaks)), duration]
        states = np.empty((len(times), len(y)))
        states[0] = y
        # A break belongs to the stretch before it: the stretch after begins an instant later.
        for begin, end in itertools.pairwise(points):
            inside = [k for k, t in enumerate(times) if begin < t <= end]
            ask = [times[k] for k in inside]
            if not ask or ask[-1] < end:
                ask.append(end)
            early = begin if begin == 0 else begin * (1 + 1e-15)
            late = end if end == duration else end * (1 - 1e-15)
            ask = [min(max(t, early), late) for t in ask]
            # After a stretch of rest a longer step would pass over a source's next pulse.
            options = {"method": method, "rtol": rtol, "atol": atol, "max_step": duration / 100}
            found = solve_ivp(slope, (early, late), y, t_eval=ask, **options)
            if found.status != 0 or not np.isfinite(found.y).all():
                raise NoSolution(found.message)
            for n, k in enumerate(inside):
                states[k] = found.y[:, n]
            y = found.y[:, -1].copy()
            y[: self.nx] = self._after(y[: self.nx], end)
            for k in inside:
                if abs(times[k] - end) < 1e-9:
                    states[k] = y
        return states


def _apart(times: list[float]) -> list[float]:
    """Times without those that rounding alone tells from the one before."""
    return [t for k, t in enumerate(times) if not k or t - times[k - 1] > 1e-9]


__all__ = ["IllPosed", "NoSolution", "Reference", "Trajectory"]
