"""All algebraic variables at a state, by Newton's method and hidden constraints."""

from __future__ import annotations

import numpy as np
from dense_rows import IllPosed, NoSolution, Rows, equilibrated


class Solving(Rows):
    """Rows that are solved for the variables z, given the states and the time."""

    def probe(self, x: np.ndarray, t: float = 0.0) -> None:
        """Find the generic rank of the nonlinear rows near a state, and so their index."""
        if not self.m:
            self.generic_rank = 0
            if len(self.nonlinear):
                raise IllPosed("more rows than variables")
            return
        rng = np.random.default_rng(1)
        ranks = []
        for _ in range(3):
            at = x + 1e-2 * rng.standard_normal(self.nx) * (np.abs(x) + 1)
            w = self._w + 1e-2 * rng.standard_normal(self.m)
            z = self.zx @ at + self.z0 + self.n @ w
            tables = self._jacobians(at.tolist(), z.tolist(), t + 1e-3)
            j = self._by_w(tables["z"])
            rows, columns = equilibrated(j)
            sizes = np.linalg.svd(rows[:, None] * j * columns, compute_uv=False)
            ranks.append(int(np.sum(sizes > 1e-8 * max(sizes[0], 1e-300))))
        self.generic_rank = max(ranks)
        if len(self.nonlinear) > self.m and self.generic_rank == self.m:
            raise IllPosed("more rows than variables")

    def solve(self, x: np.ndarray, t: float) -> np.ndarray:
        """All z at a state."""
        base = self.zx @ x + self.z0
        if not self.m:
            return base
        if self.generic_rank is None:
            self.probe(x, t)
        xs = x.tolist()
        w = self._newton(xs, base, t, self._w)
        if w is None:
            w = self._searched(xs, base, t)
        self._w = w
        z = base + self.n @ w
        self._check(x, z)
        return z

    def _check(self, x: np.ndarray, z: np.ndarray) -> None:
        """Raise NoSolution where the elimination of linear rows has lost their digits."""
        lz, lx, lc = self.lz[self.certain], self.lx[self.certain], self.lc[self.certain]
        missed = np.abs(lz @ z + lx @ x + lc)
        size = np.abs(lz) @ np.abs(z) + np.abs(lx) @ np.abs(x) + np.abs(lc)
        if not (missed <= 1e-5 * (size + 1e-6 * np.abs(size).max(initial=0.0))).all():
            raise NoSolution("the elimination of linear rows has lost their digits")

    def _searched(self, xs: list[float], base: np.ndarray, t: float) -> np.ndarray:
        """A solution from other first guesses, near to far."""
        rng = np.random.default_rng(7)
        for k in range(12):
            guess = rng.standard_normal(self.m) * 0.03 * 2.0**k
            w = self._newton(xs, base, t, guess)
            if w is not None:
                return w
        raise NoSolution(f"Newton's method finds no solution at t = {t:.6g}")

    def _newton(
        self, x: list[float], base: np.ndarray, t: float, w: np.ndarray
    ) -> np.ndarray | None:
        """Damped Newton iterations; None where they do not converge."""
        found, before = self._system(x, base, t, w), np.inf
        for count in range(60):
            if count == 6 and self.generic_rank < self.m and not self._exact:
                self._exact = True
                found = self._system(x, base, t, w)
            if found is None:
                return None
            r, j = found
            rows = 1 / np.maximum(np.abs(j).max(axis=1), 1e-300)
            table = rows[:, None] * j
            try:
                step = self._solved(table, -rows * r)
            except np.linalg.LinAlgError:
                return None
            size = 1e-9 + float(np.abs(w).max())
            change = float(np.abs(step).max()) / size
            if change < 1e-15:
                return w + step
            norm, share = float(np.linalg.norm(rows * r)), 1.0
            while True:
                found = self._system(x, base, t, w + share * step)
                if found is not None and change < 1e-6:
                    break
                if (
                    found is not None
                    and np.linalg.norm(rows * found[0]) <= (1 - 0.1 * share) * norm
                ):
                    break
                share /= 2
                if share < 1e-4:
                    return w + step if change < 1e-9 else None
            w = w + share * step
            # To the level of rounding: variables of other parts may be much smaller.
            if change < 1e-9 and change > 0.2 * before:
                return w
            before = change
        return None

    def _solved(self, table: np.ndarray, target: np.ndarray) -> np.ndarray:
        if self.generic_rank == self.m == len(table):
            return np.linalg.solve(table, target)
        across = 1 / np.maximum(np.abs(table).max(axis=0), 1e-300)
        step, _, rank, _ = np.linalg.lstsq(table * across, target, rcond=1e-11)
        if rank < self.m:
            raise IllPosed("rows of a high index")
        return np.asarray(across * step)

    def _system(
        self, x: list[float], base: np.ndarray, t: float, w: np.ndarray
    ) -> tuple[np.ndarray, np.ndarray] | None:
        """Residuals and their slopes by w, the hidden constraints included."""
        z = (base + self.n @ w).tolist()
        try:
            count = len(self.nonlinear)
            values = np.array(self._rows_by_z(x, z, t))
            r = values[:count]
            j = self._by_w(self._table(values[count:], "z"))
            if not (self.generic_rank == self.m == len(self.nonlinear)):
                rows, columns = equilibrated(j)
                u, _, _ = np.linalg.svd(rows[:, None] * j * columns)
                left = (u[:, self.generic_rank :] * rows[:, None]).T
                h, slope = self._hidden(left, x, z, t, w)
                keep = (u[:, : self.generic_rank] * rows[:, None]).T
                r, j = np.concatenate([keep @ r, h]), np.vstack([keep @ j, slope])
        except (OverflowError, ZeroDivisionError, ValueError):
            return None
        return (r, j) if np.isfinite(j).all() and np.isfinite(r).all() else None

    def _hidden(
        self, left: np.ndarray, x: list[float], z: list[float], t: float, w: np.ndarray
    ) -> tuple[np.ndarray, np.ndarray]:
        """The derivative of `left . rows` along the motion, and its slope by w."""

        def along(zs: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
            tables = self._jacobians(x, zs.tolist(), t)
            by_x = left @ (tables["x"] + tables["z"] @ self.zx) @ self.s
            return by_x @ zs + left @ tables["t"][:, 0], by_x

        here = np.array(z)
        h, by_x = along(here)
        slope = by_x @ self.n
        if self._exact:
            step = 1e-6 * (1 + float(np.abs(w).max(initial=0.0)))
            for k in range(self.m):
                d = self.n[:, k]
                slope[:, k] = (along(here + step * d)[0] - along(here - step * d)[0]) / (2 * step)
        return h, slope
