"""Programs made by hand, and their compiled C behind ctypes, for the tests of emission."""

from __future__ import annotations

import ctypes
import subprocess
from collections.abc import Sequence
from pathlib import Path

import numpy as np

from bgc.algebra.dag import Dag, Kind, Op, Symbol
from bgc.diagnostics.source import Source, Span
from bgc.emission.emit import EmittedModel
from bgc.ir.graph import Guard, Observation, Parameter
from bgc.ir.program import Energy, MassEntry, PositiveParameter, Program, ProgramState
from bgc.language.scene import Scene

RUNTIME = Path(__file__).parents[2] / "runtime" / "c"
STRICT = (
    "-Wall",
    "-Wextra",
    "-Wconversion",
    "-Wpedantic",
    "-Wdouble-promotion",
    "-Wshadow",
    "-Werror",
)
SPAN = Span(Source("<test>", ""), 0, 0)


def make_program(
    dag: Dag,
    derivatives: Sequence[int],
    *,
    parameters: Sequence[tuple[str, int]] = (),
    mass: Sequence[tuple[int, int, int]] | None = None,
    outputs: Sequence[int] = (),
    guards: Sequence[int] = (),
    positive: Sequence[int] = (),
    initial: Sequence[int] = (),
    projections: dict[int, int] | None = None,
    inputs: int = 0,
) -> Program:
    """A program from the nodes of its right-hand sides and of whatever else a test is about."""
    projections = projections or {}
    return Program(
        dag=dag,
        scene=Scene("test", "Test", (), duration=1.0),
        parameters=tuple(
            Parameter(k, name, "kg", value, None, None, SPAN)
            for k, (name, value) in enumerate(parameters)
        ),
        states=tuple(
            ProgramState(
                name=f"x{k}",
                unit="m",
                kind="declared",
                initial=initial[k] if initial else dag.zero,
                derivative=node,
                projection=projections.get(k),
                scale=dag.one,
            )
            for k, node in enumerate(derivatives)
        ),
        mass=None if mass is None else tuple(MassEntry(*entry) for entry in mass),
        inputs=inputs,
        observations=tuple(Observation(f"y{k}", "m", node, SPAN) for k, node in enumerate(outputs)),
        requirements=(),
        devices=(),
        guards=tuple(Guard(node, f"guard {k}?", SPAN) for k, node in enumerate(guards)),
        energy=Energy(*(dag.const(k) for k in (1, 2, 3))),
        positive=tuple(PositiveParameter(node, "must be positive", True) for node in positive),
        dropped=(),
    )


def states(dag: Dag, count: int) -> list[int]:
    return [dag.symbol(Kind.STATE, k) for k in range(count)]


def at(
    x: Sequence[float], *, t: float = 0.0, p: Sequence[float] = (), u: Sequence[float] = ()
) -> dict[Symbol, float]:
    """Values of symbols, as `evaluate_nodes` takes them."""
    values = {Symbol(Kind.TIME, 0): t}
    for kind, numbers in ((Kind.STATE, x), (Kind.PARAM, p), (Kind.INPUT, u)):
        values |= {Symbol(kind, k): float(number) for k, number in enumerate(numbers)}
    return values


def random_program(seed: int, size: int, operations: int) -> Program:
    """A program whose equations are random smooth expressions, defined everywhere."""
    rng = np.random.default_rng(seed)
    dag = Dag()
    x = states(dag, size)
    p = [dag.symbol(Kind.PARAM, k) for k in range(3)]
    leaves = [*x, *p, dag.symbol(Kind.TIME), dag.symbol(Kind.INPUT, 0), dag.const(0.3)]
    nodes = list(leaves)
    bounded = (Op.SIN, Op.COS, Op.TANH, Op.ATAN)
    while len(nodes) < operations:
        a, b, c = (nodes[k] for k in rng.integers(max(0, len(nodes) - 60), len(nodes), 3))
        match rng.integers(9):
            case 0 | 1:
                nodes.append(dag.add(a, dag.call(bounded[rng.integers(4)], b)))
            case 2:
                nodes.append(dag.sub(dag.call(Op.SIN, a), dag.mul(dag.const(0.5), b)))
            case 3 | 4:
                nodes.append(dag.mul(dag.call(Op.COS, a), dag.call(Op.TANH, b)))
            case 5:
                nodes.append(dag.div(dag.call(Op.SIN, a), dag.add(dag.one, dag.mul(b, b))))
            case 6:
                less = dag.call(Op.LT, a, b)
                nodes.append(dag.select(less, dag.call(Op.SIN, c), dag.call(Op.COS, c)))
            case 7:
                nodes.append(dag.call(Op.TANH, dag.call(Op.MAX, a, dag.call(Op.MIN, b, c))))
            case _:
                nodes.append(leaves[rng.integers(len(leaves))])
    derivatives = [nodes[k] for k in rng.integers(len(nodes) // 2, len(nodes), size)]
    return make_program(
        dag,
        derivatives,
        parameters=[("a", dag.const(1)), ("b", dag.const(2)), ("c", dag.mul(p[0], p[1]))],
        outputs=[nodes[k] for k in rng.integers(len(nodes) // 2, len(nodes), 5)],
        guards=[dag.call(Op.LT, x[0], dag.const(2))],
        positive=[dag.sub(p[2], p[0])],
        initial=[dag.call(Op.EXP, dag.mul(p[0], dag.const(k))) for k in range(size)],
        projections={0: dag.mul(x[0], x[1]), 1: dag.add(x[0], x[1])},
        inputs=1,
    )


class _Channel(ctypes.Structure):
    _fields_ = [("device", ctypes.c_int), ("channel", ctypes.c_int), ("component", ctypes.c_int)]


class _Range(ctypes.Structure):
    _fields_ = [("low", ctypes.c_double), ("high", ctypes.c_double)]


class _Complex(ctypes.Structure):
    _fields_ = [("re", ctypes.c_double), ("im", ctypes.c_double)]


class _Model(ctypes.Structure):
    """`struct bgc_model` of bgc.h."""

    _fields_ = [
        ("abi", ctypes.c_uint32),
        ("name", ctypes.c_char_p),
        ("hash", ctypes.c_char_p),
        *(
            (name, ctypes.c_int)
            for name in (
                "n_param n_hoist n_state n_input n_output n_command n_assert n_device "
                "n_jac n_mass n_lu n_work"
            ).split()
        ),
        *((f"table{k}", ctypes.c_void_p) for k in range(3)),
        ("input", ctypes.POINTER(_Channel)),
        *((f"more{k}", ctypes.c_void_p) for k in range(2)),
        ("assertion", ctypes.POINTER(ctypes.c_char_p)),
        ("param_check", ctypes.POINTER(ctypes.c_char_p)),
        ("n_check", ctypes.c_int),
        *(
            (name, ctypes.POINTER(ctypes.c_int))
            for name in (
                "jac_row jac_col mass_row mass_col "
                "pivot_row pivot_col lu_row lu_pivot lu_col lu_jac lu_mass"
            ).split()
        ),
        ("switch_info", ctypes.c_void_p),
        ("n_switch", ctypes.c_int),
        ("n_timed", ctypes.c_int),
        *((name, ctypes.c_double) for name in ("step", "duration", "every")),
        *(
            (name, ctypes.c_void_p)
            for name in (
                "prepare positive defaults initial scale mass rhs jacobian factor solve "
                "outputs commands energy project switches timed_switches timed_ranges "
                "asserts"
            ).split()
        ),
        ("n_divisor", ctypes.c_int),
        *((name, ctypes.c_void_p) for name in ("divisor", "divisors")),
        ("n_start", ctypes.c_int),
        *((name, ctypes.c_void_p) for name in "start_guess start started".split()),
        ("n_given", ctypes.c_int),
        *((name, ctypes.c_void_p) for name in "given_name given_kind given switch_state".split()),
        ("n_switch_state", ctypes.c_int),
        ("n_term", ctypes.c_int),
        *((name, ctypes.c_void_p) for name in "ranges closure_info closures".split()),
        ("n_watch", ctypes.c_int),
        *((name, ctypes.c_void_p) for name in "watch watch_state".split()),
        ("n_watch_state", ctypes.c_int),
        ("watched", ctypes.c_void_p),
        *((name, ctypes.c_int) for name in "n_jump n_edge".split()),
        *(
            (name, ctypes.c_void_p)
            for name in "jump_first reset_state edge_switch conditions resets edge_rates".split()
        ),
        *((name, ctypes.c_int) for name in "n_held n_rate n_slot".split()),
        *(
            (name, ctypes.c_void_p)
            for name in "held_input held_rate sampling held_start held".split()
        ),
        ("n_port", ctypes.c_int),
        ("book", ctypes.c_void_p),
        *((name, ctypes.c_int) for name in "n_inner n_local".split()),
        *((name, ctypes.c_void_p) for name in "local_row local_col blocks".split()),
        ("explicit_cost", ctypes.c_double),
        ("switches_after_rhs", ctypes.c_void_p),
    ]


class CompiledModel:
    """Functions of a model on NumPy arrays; every result is NaN before the call."""

    def __init__(self, emitted: EmittedModel, place: Path, p: Sequence[float] = ()) -> None:
        sources = []
        for unit in emitted.units:
            path = place / f"{unit.name}.c"
            path.write_text(unit.text, encoding="utf-8")
            sources.append(path.name)
            for name, content in unit.files:
                (place / name).write_bytes(content)
        command = ["cc", *emitted.units[0].flags, *STRICT, f"-I{RUNTIME}", "-shared"]
        sources.append(str(RUNTIME / "sparse.c"))
        subprocess.run([*command, *sources, "-o", "model.so", "-lm"], cwd=place, check=True)
        self._library = ctypes.CDLL(str(place / "model.so"))
        self._library.bgc_get_model.restype = ctypes.POINTER(_Model)
        self.model = self._library.bgc_get_model().contents
        self.work = self._poisoned(self.model.n_work)
        self.set_parameters(p)

    def set_parameters(self, p: Sequence[float]) -> None:
        self.p = np.array(p, dtype=float)
        self.h = self._poisoned(self.model.n_hoist)
        self._call("prepare", self.p, self.h, self.work)

    @staticmethod
    def _poisoned(size: int) -> np.ndarray:
        return np.full(max(size, 1), np.nan)

    def _call(self, name: str, *arguments: object) -> int:
        types, values = [], []
        for argument in arguments:
            if isinstance(argument, np.ndarray):
                types.append(ctypes.c_void_p)
                values.append(argument.ctypes.data)
            else:
                types.append(ctypes.c_double)
                values.append(argument)
        function = ctypes.CFUNCTYPE(ctypes.c_int, *types)(getattr(self.model, name))
        return int(function(*values))

    def _evaluate(
        self,
        name: str,
        size: int,
        t: float,
        x: np.ndarray,
        u: np.ndarray,
        modes: Sequence[float] | None = None,
    ) -> np.ndarray:
        out = self._poisoned(size)
        self._call(name, self.h, t, x, self._with_modes(u, modes), out, self.work)
        return out[:size]

    def _with_modes(self, u: np.ndarray, modes: Sequence[float] | None) -> np.ndarray:
        """Inputs, then modes; without any, all comparisons are made."""
        held = self._poisoned(self.model.n_switch) if modes is None else np.array(modes)
        return np.concatenate([u[: self.model.n_input], held])

    def ranges(self, low: float, high: float) -> np.ndarray:
        """Ranges of the terms of time alone and of their derivatives, (n_term, 2, 2)."""
        h = np.repeat(self.h, 2)
        u = np.full(2 * (self.model.n_input + self.model.n_switch) + 1, np.nan)
        b = self._poisoned(4 * self.model.n_term)
        arrays = (h, u, b, self.work)
        types = (ctypes.c_void_p, _Range, *[ctypes.c_void_p] * 3)
        first, *others = (array.ctypes.data for array in arrays)
        ctypes.CFUNCTYPE(None, *types)(self.model.ranges)(first, _Range(low, high), *others)
        return b[: 4 * self.model.n_term].reshape(-1, 2, 2)

    def switches(self, t: float, x: np.ndarray, u: np.ndarray) -> np.ndarray:
        return self._evaluate("switches", self.model.n_switch, t, x, u)

    def switches_after_rhs(self, t: float, x: np.ndarray, u: np.ndarray) -> np.ndarray:
        return self._evaluate("switches_after_rhs", self.model.n_switch, t, x, u)

    def rhs(
        self, t: float, x: np.ndarray, u: np.ndarray, modes: Sequence[float] | None = None
    ) -> np.ndarray:
        return self._evaluate("rhs", self.model.n_state, t, x, u, modes)

    def outputs(
        self, t: float, x: np.ndarray, u: np.ndarray, modes: Sequence[float] | None = None
    ) -> np.ndarray:
        return self._evaluate("outputs", self.model.n_output, t, x, u, modes)

    def asserts(self, t: float, x: np.ndarray, u: np.ndarray) -> np.ndarray:
        return self._evaluate("asserts", self.model.n_assert, t, x, u)

    def energy(self, t: float, x: np.ndarray, u: np.ndarray) -> np.ndarray:
        return self._evaluate("energy", 3, t, x, u)

    def initial(self, t: float, u: np.ndarray) -> np.ndarray:
        out = self._poisoned(self.model.n_state)
        self._call("initial", self.h, t, u, out, self.work)
        return out

    def project(self, t: float, x: np.ndarray) -> np.ndarray:
        out = x.copy()
        self._call("project", self.h, t, out, self.work)
        return out

    def checks(self) -> np.ndarray:
        out = self._poisoned(self.model.n_check)
        self._call("positive", self.p, self.h, out, self.work)
        return out

    def defaults(self, p: np.ndarray, is_set: Sequence[int]) -> np.ndarray:
        out = p.copy()
        self._call("defaults", out, np.array(is_set, dtype=np.uint8), self.work)
        return out

    def entries(
        self, t: float, x: np.ndarray, u: np.ndarray, modes: Sequence[float] | None = None
    ) -> tuple[np.ndarray, np.ndarray]:
        """Stored entries of the Jacobian, and df/dt."""
        jac, dfdt = self._poisoned(self.model.n_jac), self._poisoned(self.model.n_state)
        self._call("jacobian", self.h, t, x, self._with_modes(u, modes), jac, dfdt, self.work)
        return jac[: self.model.n_jac], dfdt

    def dense(self, entries: np.ndarray, which: str = "jac") -> np.ndarray:
        """Stored entries of J or M as a matrix."""
        matrix = np.zeros((self.model.n_state, self.model.n_state))
        row, column = getattr(self.model, f"{which}_row"), getattr(self.model, f"{which}_col")
        for k, value in enumerate(entries):
            matrix[row[k], column[k]] = value
        return matrix

    def mass(self) -> np.ndarray:
        entries = self._poisoned(self.model.n_mass)
        self._call("mass", self.h, entries, self.work)
        if not self.model.n_mass:
            return np.eye(self.model.n_state)
        return self.dense(entries[: self.model.n_mass], "mass")

    def factor(self, jac: np.ndarray, c: float) -> tuple[int, np.ndarray, float]:
        """Status, factors and growth."""
        m = self._poisoned(self.model.n_mass)
        self._call("mass", self.h, m, self.work)
        lu, growth = self._poisoned(self.model.n_lu), self._poisoned(1)
        status = self._call("factor", m, jac, c, lu, growth)
        return status, lu, float(growth[0])

    def solve_by_tables(self, jac: np.ndarray, c: complex, b: np.ndarray) -> np.ndarray:
        """(c M - J)^-1 b, c real or complex, by the runtime's loops over the model's tables."""
        is_complex = isinstance(c, complex)
        numbers = 2 if is_complex else 1
        m = self._poisoned(self.model.n_mass)
        self._call("mass", self.h, m, self.work)
        lu = self._poisoned(numbers * self.model.n_lu)
        work = self._poisoned(3 * self.model.n_state)
        model = ctypes.addressof(self.model)
        growth = self._poisoned(1)
        at = [array.ctypes.data for array in (m, jac)]
        if is_complex:
            factor = self._library.bgc_sparse_factor_complex
            factor.argtypes = [*[ctypes.c_void_p] * 3, _Complex, *[ctypes.c_void_p] * 3]
            shift: complex | _Complex = _Complex(c.real, c.imag)
        else:
            factor = self._library.bgc_sparse_factor
            factor.argtypes = [*[ctypes.c_void_p] * 3, ctypes.c_double, *[ctypes.c_void_p] * 3]
            shift = c
        more = (lu.ctypes.data, growth.ctypes.data, work.ctypes.data)
        assert factor(model, *at, shift, *more) == 0
        assert growth[0] > 0
        x = b.astype(complex if is_complex else float)
        library = self._library
        solve = library.bgc_sparse_solve_complex if is_complex else library.bgc_sparse_solve
        solve.argtypes = [ctypes.c_void_p] * 4
        solve(model, lu.ctypes.data, x.ctypes.data, work.ctypes.data)
        return x

    def solve(self, lu: np.ndarray, b: np.ndarray) -> np.ndarray:
        out = b.copy()
        self._call("solve", lu, out, self.work)
        return out
