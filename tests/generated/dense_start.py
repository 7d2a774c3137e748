"""Initial states: what is given; of dependent storage the rest of least energy."""

from __future__ import annotations

import numpy as np
from dense_rows import IllPosed, NoSolution
from dense_solve import Solving


class Starting(Solving):
    """Rows with the states that a run starts from."""

    def start(self) -> np.ndarray:
        """The initial state: what is given; of dependent storage the rest of least energy."""
        with np.errstate(all="ignore"):
            try:
                return self._start()
            except (OverflowError, ZeroDivisionError) as err:
                raise NoSolution(str(err)) from err

    def _start(self) -> np.ndarray:
        x = np.zeros(self.nx)
        for k, value in self.raw.given.items():
            x[k] = value
        fixed = sorted(self.raw.given)
        free = [k for k in range(self.nx) if k not in self.raw.given]
        self.probe(x)
        count = len(self.nonlinear)
        self.hidden = 0 if self.generic_rank is None else count - self.generic_rank
        conditions = len(self.raw.conditions)
        if not len(self.cx) and not self.hidden and not conditions:
            return x
        if not free:
            if np.abs(self._start_residual(x, self._w)).max(initial=0.0) > 1e-8:
                raise IllPosed("initial values contradict each other")
            return x
        del fixed
        return self._least_energy(x, free)

    def _start_residual(self, x: np.ndarray, w: np.ndarray) -> np.ndarray:
        """Residuals of the conditions on the start; infinite where they overflow."""
        try:
            return self._start_conditions(x, w)
        except (OverflowError, ZeroDivisionError, ValueError) as err:
            raise NoSolution(str(err)) from err

    def _start_conditions(self, x: np.ndarray, w: np.ndarray) -> np.ndarray:
        z = self.zx @ x + self.z0 + (self.n @ w if self.m else 0.0)
        rows = self._rows(x.tolist(), z.tolist(), 0.0) if self.hidden else []
        return np.concatenate(
            [self.cx @ x + self.cc, rows, self._conditions(x.tolist(), z.tolist(), 0.0)]
        )

    def _start_slope(self, x: np.ndarray, w: np.ndarray) -> np.ndarray:
        """The slope of these residuals by x and w; that of given efforts and flows differenced."""
        z = self.zx @ x + self.z0 + (self.n @ w if self.m else 0.0)
        tables = self._jacobians(x.tolist(), z.tolist(), 0.0)
        by_x = np.hstack([self.cx, np.zeros((len(self.cx), self.m))])
        parts = [by_x]
        if self.hidden:
            through = tables["x"] + tables["z"] @ self.zx
            parts.append(np.hstack([through, self._by_w(tables["z"])]))
        if self.raw.conditions:
            rows = np.zeros((len(self.raw.conditions), self.nx + self.m))
            for k in range(self.nx):
                step = 1e-6 * max(abs(x[k]), 1e-3)
                there, back = x.copy(), x.copy()
                there[k] += step
                back[k] -= step
                change = np.subtract(
                    self._conditions(there.tolist(), z.tolist(), 0.0),
                    self._conditions(back.tolist(), z.tolist(), 0.0),
                )
                rows[:, k] = change / (2 * step)
            parts.append(rows)
        return np.vstack(parts)

    def _least_energy(self, x: np.ndarray, free: list[int]) -> np.ndarray:
        """Newton's method on the Lagrangian, with slopes by differences."""
        states = {s.var.index: n for n, s in enumerate(self.raw.storage)}
        held = self.m if self.hidden else 0
        w = self._w.copy()

        def gradient(at: np.ndarray) -> np.ndarray:
            z = [0.0] * self.nz
            slopes = self._slopes(at.tolist(), z, 0.0)
            return np.array([slopes[states[k]] if k in states else 0.0 for k in free])

        size = len(free) + held
        for _ in range(60):
            residual = self._start_residual(x, w)
            slope = self._start_slope(x, w)[:, [*free, *range(self.nx, self.nx + held)]]
            hessian = np.zeros((size, size))
            g = np.zeros(size)
            g[: len(free)] = gradient(x)
            for n, k in enumerate(free):
                step = 1e-6 * max(abs(x[k]), 1e-3)
                there, back = x.copy(), x.copy()
                there[k] += step
                back[k] -= step
                hessian[: len(free), n] = (gradient(there) - gradient(back)) / (2 * step)
            # Variables in units of the root of an energy, residuals in units of variables.
            curvature = np.abs(np.diag(hessian))
            size_of = 1 / np.sqrt(np.where(curvature > 0, curvature, 1.0))
            weights = 1 / np.maximum(np.abs(slope * size_of).max(axis=1, initial=0.0), 1e-300)
            table = weights[:, None] * slope * size_of
            missed = weights * residual
            curved = size_of[:, None] * hessian * size_of
            kkt = np.block([[curved, table.T], [table, np.zeros((len(missed),) * 2)]])
            target = -np.concatenate([size_of * g, missed])
            if not (np.isfinite(kkt).all() and np.isfinite(target).all()):
                raise NoSolution("initial values run to infinity")
            move = size_of * np.linalg.lstsq(kkt, target, rcond=1e-12)[0][:size]
            x = x.copy()
            x[free] += move[: len(free)]
            w = w + move[len(free) :] if held else w
            if np.all(np.abs(move / size_of) < 1e-12 * (1 + np.abs(missed).max(initial=0.0))):
                break
        # Rows are compared with their own terms, for domains differ in size by orders.
        own = np.abs(self._start_slope(x, w)) @ np.abs(np.concatenate([x, w]))
        if not (np.abs(self._start_residual(x, w)) <= 1e-6 * own + 1e-12).all():
            raise IllPosed("no initial values satisfy the equations")
        if not np.abs(x).max(initial=0.0) < 1e12:
            raise IllPosed("initial values run to infinity")
        if held:
            self._w = w
        return x
