"""The rows of raw equations: linear ones eliminated, the others compiled to functions."""

from __future__ import annotations

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


class Rows:
    """The rows of one program, with their slopes."""

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
            rows, columns = equilibrated(lz)
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
        self._jumps = [
            (
                jump.period,
                [var.index for var in jump.values],
                compiled("x, z, t", [*jump.values.values()]),
            )
            for jump in raw.jumps
        ]
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


def _total(terms: list[Expr]) -> Expr:
    total: Expr = Num(Fraction(0))
    for term in terms:
        total = total + term
    return total


def equilibrated(table: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
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
