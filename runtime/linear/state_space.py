"""A linear model: state space, eigenvalues and modes, frequency response."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from typing import Any, Literal

import numpy as np
from numpy.typing import NDArray

from bgc.diagnostics.catalogue import counted
from bgc.diagnostics.catalogue.analysis import singular_mass
from bgc.diagnostics.diagnostic import BgError, Diagnostic
from bgc.diagnostics.public import public_class
from bgc.record_class import dataclass, field, replace
from bgc.runtime.results.arrays import Array, Complex
from bgc.runtime.results.columns import optional_package
from bgc.values.shown_units import Shown

_ROUNDING = 1e-14
_WELL_CONDITIONED = 1e12
_SHOWN = 12  # states up to which a notebook shows all matrices


@dataclass(frozen=True, slots=True)
class Mode:
    """A mode: its eigenvalue, 1/s, and the period of its damped oscillation, s.

    `damping` is the damping ratio, 1 where the mode does not oscillate; its period is infinite
    then. `shares` are the states by falling participation factor (products of left and right
    eigenvectors, of sum 1); empty where only eigenvalues were computed.
    """

    eigenvalue: complex
    period: float
    damping: float
    shares: tuple[tuple[str, float], ...] = ()

    @property
    def frequency(self) -> float:
        """Frequency of the damped oscillation, Hz; 0 where it does not oscillate."""
        return 1.0 / self.period

    @property
    def natural_period(self) -> float:
        """Period without damping, s: 2 pi / |eigenvalue|."""
        size = abs(self.eigenvalue)
        return 2 * math.pi / size if size > 0 and self.eigenvalue.imag > 0 else math.inf

    @property
    def time_constant(self) -> float:
        """Time of decay to 1/e, s; negative where the mode grows."""
        real = self.eigenvalue.real
        return -1 / real if real != 0 else math.inf


@public_class
@dataclass(frozen=True, repr=False)
class Linearisation:
    """`E dx' = A dx + B du`, `dy = C dx + D du` about an operating point.

    `E` is the identity unless the model's mass matrix is singular beyond the algebraic
    equations, which have been solved; then `scipy.signal.StateSpace(lin.A, lin.B, lin.C, lin.D)`
    and `control.ss(...)` take the four others as they are.

    Attributes
    ----------
    A, B, C, D, E
        Matrices, (n, n), (n, m), (p, n), (p, m), (n, n); SI units.
    states, inputs, outputs
        Their names.
    units
        SI units by those names.
    point, time
        The operating point: values of the states, (n,), SI, and the time, s.
    shown
        The units as written of the states that are not shown in their SI unit.
    warnings
        Warnings of the compiler about the model with the values of this call.
    """

    A: Array
    B: Array
    C: Array
    D: Array
    E: Array
    states: tuple[str, ...]
    inputs: tuple[str, ...]
    outputs: tuple[str, ...]
    units: dict[str, str]
    point: Array
    time: float
    shown: Mapping[str, Shown] = field(default_factory=dict)
    warnings: tuple[Diagnostic, ...] = ()

    def shown_in(self, name: str) -> Shown:
        """The unit in which a state is shown: as written, else its SI unit."""
        return self.shown.get(name) or Shown(self.units[name])

    @property
    def is_explicit(self) -> bool:
        """True if E is the identity."""
        return np.array_equal(self.E, np.eye(len(self.E)))

    def channel(self, output: int, input_: int) -> Linearisation:
        """Take one output and one input, by their places from 0, and all states.

        `output` and `input_` count in the order of `outputs` and `inputs`.
        """
        return replace(
            self,
            B=self.B[:, [input_]],
            C=self.C[[output]],
            D=self.D[[output]][:, [input_]],
            inputs=(self.inputs[input_],),
            outputs=(self.outputs[output],),
        )

    def eigenvalues(self) -> Complex:
        """Eigenvalues in 1/s, by rising real part, then rising imaginary part."""
        return pencil_eigenvalues(self.A, self.E)

    def modes(self) -> tuple[Mode, ...]:
        """Modes by rising frequency, one of each conjugate pair, with their states."""
        if not self.is_explicit or not len(self.A):
            return modes_of(self.eigenvalues())
        return modes_with_vectors(self.A, self.E, self.states)[0]

    def to_ss(self, package: Literal["scipy", "control"] = "scipy") -> Any:
        """Return a state space of SciPy, or of python-control with the names of all signals.

        python-control keeps the dot for systems and their signals: `supply.e` is `supply_e` there.
        `package` chooses `scipy.signal.StateSpace` or `control.StateSpace`; a mass matrix E that
        is not the identity is divided out.

        Raises
        ------
        BgError
            E is singular (BG794), or python-control is not installed (BG058).
        """
        A: Array = self.A
        B: Array = self.B
        if not self.is_explicit:
            if np.linalg.cond(self.E) > _WELL_CONDITIONED:
                raise BgError([singular_mass()])
            A = np.asarray(np.linalg.solve(self.E, A), dtype=np.float64)
            B = np.asarray(np.linalg.solve(self.E, B), dtype=np.float64)
        if package == "control":
            control = optional_package("control", "`to_ss`")
            names = {"states": self.states, "inputs": self.inputs, "outputs": self.outputs}
            undotted = {kind: _without_dots(some) for kind, some in names.items()}
            return control.ss(A, B, self.C, self.D, **undotted)
        # Slow to load, and few linear models go there.
        from scipy.signal import StateSpace

        return StateSpace(A, B, self.C, self.D)

    def _repr_html_(self) -> str:
        # Only a notebook needs it.
        from bgc.printing.text_tables import Table
        from bgc.runtime.results.html import tables_html

        modes = tuple(
            (
                f"{mode.eigenvalue:.5g}",
                f"{mode.natural_period:.5g} s",
                f"{mode.damping:.4g}",
                ", ".join(name for name, _ in mode.shares[:2]),
            )
            for mode in self.modes()
        )
        header = ("eigenvalue [1/s]", "natural period", "damping ratio", "states")
        tables = [Table(repr(self).strip("<>"), header, modes)]
        if len(self.states) <= _SHOWN:
            rates = tuple(f"d {name}/dt" for name in self.states)
            tables += [
                Table(title, ("", *columns), _rows(names, matrix))
                for title, names, columns, matrix in (
                    ("A", rates, self.states, self.A),
                    ("B", rates, self.inputs, self.B),
                    ("C", self.outputs, self.states, self.C),
                    ("D", self.outputs, self.inputs, self.D),
                )
                if matrix.size
            ]
        return tables_html(tables)

    def __repr__(self) -> str:
        parts = (("state", self.states), ("input", self.inputs), ("output", self.outputs))
        size = ", ".join(counted(len(names), noun) for noun, names in parts)
        return f"<bgc linear form at {self.time:g} s: {size}>"

    def response(self, omega: Array) -> Complex:
        """Compute the transfer matrix `C (i w E - A)^-1 B + D`, (k, p, m), at `omega`, rad/s, (k,).

        NaN at a frequency that is exactly that of an undamped mode.
        """
        values = np.empty((len(omega), len(self.outputs), len(self.inputs)), dtype=np.complex128)
        for k, w in enumerate(omega):
            try:
                values[k] = self.C @ np.linalg.solve(1j * w * self.E - self.A, self.B) + self.D
            except np.linalg.LinAlgError:
                values[k] = np.nan
        return values


def _rows(names: Sequence[str], matrix: Array) -> tuple[tuple[str, ...], ...]:
    """The rows of a matrix as texts, each behind its name."""
    return tuple(
        (name, *(f"{value:.5g}" for value in row))
        for name, row in zip(names, matrix.tolist(), strict=True)
    )


def pencil_eigenvalues(matrix: Array, mass: Array) -> Complex:
    """Compute the eigenvalues of `mass dy' = matrix dy`, 1/s, by rising real, then imaginary part.

    For an equation without hidden constraints, their number is the rank of `mass`: variables that
    algebraic equations determine have none.
    """
    if np.array_equal(mass, np.eye(len(mass))):
        found = np.linalg.eigvals(matrix)
    else:
        none = np.empty((len(matrix), 0))
        A, _, _, _, E, _ = without_algebraic(matrix, none, none.T, np.empty((0, 0)), mass)
        found = np.linalg.eigvals(A) if np.array_equal(E, np.eye(len(E))) else _finite(A, E)
    return by_real_part(found)


def by_real_part(values: NDArray[Any]) -> Complex:
    """Sort by rising real part, then rising imaginary part."""
    order = np.lexsort((values.imag, values.real))
    return np.asarray(values, dtype=np.complex128)[order]


def modes_of(eigenvalues: Complex) -> tuple[Mode, ...]:
    """Make modes of eigenvalues, by rising frequency, one of each conjugate pair."""
    modes = (_mode(value) for value in eigenvalues.tolist() if value.imag >= 0)
    return tuple(sorted(modes, key=_frequency))


def modes_with_vectors(
    matrix: Array, mass: Array, states: Sequence[str]
) -> tuple[tuple[Mode, ...], Complex]:
    """Compute the modes of `mass dy' = matrix dy` with their states, by rising frequency.

    One of each conjugate pair; the columns of the second result, (n, modes), are its right
    eigenvectors.
    """
    if not len(matrix):
        return (), np.empty((0, 0), dtype=np.complex128)
    # Slow to load; NumPy has no left eigenvectors.
    from scipy.linalg import eig

    explicit = np.array_equal(mass, np.eye(len(mass)))
    values, left, right = eig(matrix, None if explicit else mass, left=True, right=True)
    found = []
    for k in np.flatnonzero(np.isfinite(values) & (values.imag >= 0)):
        part = np.abs(left[:, k].conj() * right[:, k])
        part = part / part.sum() if part.sum() > 0 else part
        order = np.argsort(-part, kind="stable")
        shares = tuple((states[i], float(part[i])) for i in order)
        found.append((_mode(complex(values[k]), shares), right[:, k].astype(np.complex128)))
    found.sort(key=lambda pair: _frequency(pair[0]))
    vectors = [vector for _, vector in found]
    stacked = np.stack(vectors, axis=1) if vectors else np.empty((len(matrix), 0), np.complex128)
    return tuple(mode for mode, _ in found), stacked


def without_algebraic(
    A: Array, B: Array, C: Array, D: Array, E: Array
) -> tuple[Array, Array, Array, Array, Array, NDArray[np.intp]]:
    """Eliminate the states without a rate by the algebraic equations, and invert a regular E.

    Returns A, B, C, D, E and the indices of the remaining states. E is the identity then, unless
    it is singular in the remaining states. If the algebraic equations do not determine the states
    without a rate, the system is returned unchanged.
    """
    every = np.arange(len(A))
    rows, columns = ~E.any(axis=1), ~E.any(axis=0)
    if rows.sum() != columns.sum() or not _regular(A[np.ix_(rows, columns)]):
        return A, B, C, D, E, every
    kept, left = ~rows, ~columns
    # 0 = A_ra x_l + A_rr x_c + B_r u  gives  x_c = -follow x_l - driven u
    inner = A[np.ix_(rows, columns)]
    follow = np.linalg.solve(inner, A[np.ix_(rows, left)])
    driven = np.linalg.solve(inner, B[rows])
    mass = E[np.ix_(kept, left)]
    state = A[np.ix_(kept, left)] - A[np.ix_(kept, columns)] @ follow
    input_ = B[kept] - A[np.ix_(kept, columns)] @ driven
    output = C[:, left] - C[:, columns] @ follow
    direct = D - C[:, columns] @ driven
    if not np.array_equal(mass, np.eye(len(mass))) and _regular(mass):
        both = np.linalg.solve(mass, np.hstack((state, input_)))
        state, input_ = np.hsplit(both, [len(mass)])
        mass = np.eye(len(mass))
    return state, input_, output, direct, mass, every[left]


def _regular(matrix: Array) -> bool:
    """Return whether a matrix is well conditioned after scaling its rows and columns."""
    if not len(matrix):
        return True
    by_row = matrix / np.maximum(np.abs(matrix).max(axis=1, keepdims=True), 1e-300)
    by_both = by_row / np.maximum(np.abs(by_row).max(axis=0, keepdims=True), 1e-300)
    return bool(np.linalg.cond(by_both) < _WELL_CONDITIONED)


def _finite(matrix: Array, mass: Array) -> Complex:
    """Compute the finite eigenvalues of `mass dy' = matrix dy`."""
    # Slow to load; NumPy has no generalised eigenvalues.
    from scipy.linalg import eigvals

    above, below = eigvals(matrix, mass, homogeneous_eigvals=True)
    finite = np.abs(below) > _ROUNDING * np.abs(mass).max(initial=0.0)
    found: Complex = above[finite] / below[finite]
    return found


def _mode(value: complex, shares: tuple[tuple[str, float], ...] = ()) -> Mode:
    period = 2 * math.pi / value.imag if value.imag > 0 else math.inf
    damping = 0.0 if value.real == 0 else -value.real / abs(value)
    return Mode(value, period, damping, shares)


def _frequency(mode: Mode) -> tuple[float, float]:
    """The order of modes: by frequency, those that do not oscillate by their size."""
    return mode.frequency, abs(mode.eigenvalue)


def _without_dots(names: Sequence[str]) -> list[str]:
    """Write names with underscores in place of dots; those that become equal are numbered."""
    found = [name.replace(".", "_") for name in names]
    return [f"{name}_{k}" if found.count(name) > 1 else name for k, name in enumerate(found)]
