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
from fractions import Fraction

import numpy as np
from flat_expressions import Var, compiled, derivative, linear_form, variables
from program_tree import Expr, Num
from raw_equations import Raw

_RANK = 1e-9


class IllPosed(Exception):
    """The equations have no solution, or no single one, or one of too high an index."""


class NoSolution(Exception):
    """Newton's method or the integration did not reach a result."""


@dataclass
class Trajectory:
    times: np.ndarray
    columns: dict[str, np.ndarray]
    scales: dict[str, float]


class Reference:
    """The equations of one program, ready to be solved."""

    def __init__(self, raw: Raw) -> None:
        self.raw = raw
        self.nx, self.nz = len(raw.x_names), len(raw.z_names)
        self._split()
        self._eliminate()
        self._compile()

    # --- linear rows --------------------------------------------------------------------

    def _split(self) -> None:
        linear, self.nonlinear = [], []
        for row in self.raw.rows:
            form = linear_form(row)
            if form is None:
                self.nonlinear.append(row)
            else:
                linear.append(form)
        self.lz = np.zeros((len(linear), self.nz))
        self.lx = np.zeros((len(linear), self.nx))
        self.lc = np.zeros(len(linear))
        for i, (terms, constant) in enumerate(linear):
            for var, c in terms.items():
                (self.lz if var.kind == "z" else self.lx)[i, var.index] += c
            self.lc[i] = constant
        self.s = np.zeros((self.nx, self.nz))
        for k, var in enumerate(self.raw.rate):
            self.s[k, var.index] = 1.0

    def _eliminate(self) -> None:
        """`z = zx x + z0 + n w`, and the constraints `cx x + cc = 0` that linear rows imply."""
        from scipy.linalg import qr

        lz, lx, lc = self.lz, self.lx, self.lc
        constraints: list[tuple[np.ndarray, float]] = []
        certain = np.arange(len(lz))
        for _ in range(4):
            rows, columns = _equilibrated(lz)
            scaled = rows[:, None] * lz * columns
            u, sizes, vt = np.linalg.svd(scaled)
            rank = int(np.sum(sizes > _RANK * max(sizes[0], 1e-300))) if len(sizes) else 0
            left = u[:, rank:].T * rows
            if not len(left):
                break
            more = []
            for w in left:
                on_x, constant = w @ lx, float(w @ lc)
                on_x[np.abs(on_x) <= 1e-10 * (np.abs(w) @ np.abs(lx))] = 0.0
                if not on_x.any():
                    if abs(constant) > 1e-9 * np.abs(w * lc).max(initial=1e-300):
                        raise IllPosed("linear rows contradict each other")
                    continue
                constraints.append((on_x, constant))
                more.append(on_x @ self.s)
            # Whole rows are kept, for sums of rows have entries that are rounding alone.
            keep = qr(scaled.T, mode="r", pivoting=True)[1][:rank]
            certain = certain[keep[keep < len(certain)]]
            lz = np.vstack([lz[keep], *more])
            lx = np.vstack([lx[keep], np.zeros((len(more), self.nx))])
            lc = np.concatenate([lc[keep], np.zeros(len(more))])
        else:
            raise IllPosed("linear rows of a high index")
        pseudo = (vt[:rank].T / sizes[:rank]) @ u[:, :rank].T
        inverse = columns[:, None] * pseudo * rows
        self.zx, self.z0 = -inverse @ lx, -inverse @ lc
        # Rounding must not be taken for a dependence: rows of J are brought to one size later.
        null = vt[rank:].T
        self.n = columns[:, None] * np.where(np.abs(null) < 1e-11, 0.0, null)
        self.certain = certain  # rows that are none of the constraints
        self.m = self.n.shape[1]
        self.cx = np.array([c for c, _ in constraints]).reshape(len(constraints), self.nx)
        self.cc = np.array([c for _, c in constraints])
        if len(self.nonlinear) < self.m:
            raise IllPosed(f"{self.m - len(self.nonlinear)} variables that nothing determines")

    # --- the other rows -----------------------------------------------------------------

    def _compile(self) -> None:
        raw, rows = self.raw, self.nonlinear
        entries: list[Expr] = []
        places: list[tuple[str, int, int]] = []
        for i, row in enumerate(rows):
            for var in sorted(variables(row), key=repr):
                kind, index = (var.kind, var.index) if isinstance(var, Var) else ("t", 0)
                places.append((kind, i, index))
                entries.append(derivative(row, var))
        order = sorted(range(len(places)), key=lambda n: "zxt".index(places[n][0]))
        places, entries = [places[n] for n in order], [entries[n] for n in order]
        widths = {"z": self.nz, "x": self.nx, "t": 1}
        self._spans = {}
        for kind, width in widths.items():
            own = [n for n, p in enumerate(places) if p[0] == kind]
            flat = np.array([places[n][1] * width + places[n][2] for n in own], dtype=int)
            begin = own[0] if own else 0
            self._spans[kind] = (begin, begin + len(own), flat, (len(rows), width))
        by_z = entries[: self._spans["z"][1]]
        self._rows = compiled("x, z, t", rows)
        self._rows_by_z = compiled("x, z, t", [*rows, *by_z])
        self._entries = compiled("x, z, t", entries)
        self._exact = False  # whether slopes of hidden constraints are differenced
        self._powers = compiled(
            "x, z, t", [_total(raw.stored), _total(raw.supplied), _total(raw.dissipated)]
        )
        self._observed = compiled("x, z, t", [e for _, e, _ in raw.observed])
        self._slopes = compiled("x, z, t", [s.slope for s in raw.storage])
        self._conditions = compiled("x, z, t", raw.conditions)
        guess = np.zeros(self.nz)
        for k, value in raw.guesses.items():
            guess[k] = value
        self._w = np.linalg.lstsq(self.n, guess, rcond=None)[0] if self.m else np.zeros(0)
        self.generic_rank: int | None = None

    def _table(self, values: np.ndarray, kind: str) -> np.ndarray:
        begin, end, flat, shape = self._spans[kind]
        table = np.zeros(shape)
        table.ravel()[flat] = values[begin:end]
        return table

    def _jacobians(self, x: list[float], z: list[float], t: float) -> dict[str, np.ndarray]:
        values = np.array(self._entries(x, z, t))
        return {kind: self._table(values, kind) for kind in "zxt"}

    def _by_w(self, table: np.ndarray) -> np.ndarray:
        """The slope by w from that by z, without what rounding leaves of a cancellation."""
        j = table @ self.n
        j[np.abs(j) < 1e-11 * (np.abs(table) @ np.abs(self.n))] = 0.0
        return j

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
            rows, columns = _equilibrated(j)
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
                rows, columns = _equilibrated(j)
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

    # --- the start ----------------------------------------------------------------------

    def start(self) -> np.ndarray:
        """The initial state: what is given; of dependent storage the rest of least energy."""
        with np.errstate(all="ignore"):
            return self._start()

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
        largest = np.abs(np.concatenate([x[free], w if held else []]) / size_of).max(initial=0.0)
        if not np.abs(missed).max(initial=0.0) <= 1e-8 * (largest + 1e-6):
            raise IllPosed("no initial values satisfy the equations")
        if held:
            self._w = w
        return x

    # --- the run ------------------------------------------------------------------------

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
            return self._run(duration, count, rtol, method, most)

    def _run(
        self, duration: float, count: int, rtol: float, method: str, most: float
    ) -> Trajectory:
        times = np.linspace(0.0, duration, count + 1)
        x = self.start()
        self.solve(x, 0.0)
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
        points = [0.0, *sorted(b for b in self.raw.breaks if 0 < b < duration), duration]
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
            y = found.y[:, -1]
        return states


def _total(terms: list[Expr]) -> Expr:
    total: Expr = Num(Fraction(0))
    for term in terms:
        total = total + term
    return total


def _equilibrated(table: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Factors of rows and columns that bring the geometric means of their entries to one.

    Largest entries would not do: beside `f = 1e-9 e` stand rows `e1 = e2` and `f1 = f2`.
    """
    there = table != 0
    logs = np.log(np.abs(np.where(there, table, 1.0)))
    in_rows, in_columns = np.maximum(there.sum(axis=1), 1), np.maximum(there.sum(axis=0), 1)
    rows, columns = np.zeros(table.shape[0]), np.zeros(table.shape[1])
    for _ in range(12):
        rows = -(logs + there * columns).sum(axis=1) / in_rows
        columns = -(logs + there * rows[:, None]).sum(axis=0) / in_columns
    return np.exp(rows), np.exp(columns)
