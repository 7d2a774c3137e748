"""A scene's equations as CasADi expressions: optimal control, estimation, generated C."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from pathlib import Path
from types import ModuleType
from typing import Any

import numpy as np

from bgc.algebra.dag import Dag, Kind, Symbol
from bgc.diagnostics.catalogue.analysis import singular_mass
from bgc.diagnostics.diagnostic import BgError
from bgc.ir.defaults import program_values
from bgc.ir.graph import Node
from bgc.linearising.analysis_scene import Opened, open_scene
from bgc.linearising.linear_form import Entries, linear_form
from bgc.options import Options
from bgc.record_class import dataclass
from bgc.runtime.linearising.casadi_expressions import SX, expressions
from bgc.runtime.linearising.operating_point import OpenedModel
from bgc.runtime.results.arrays import Array
from bgc.runtime.results.columns import optional_package


@dataclass(frozen=True, slots=True)
class CasadiModel:
    """The equations `M x' = f(t, x, u, p)`, `y = g(t, x, u, p)` of a scene as CasADi expressions.

    Made by `bgc.Model.casadi`. All quantities are SI, in the order of the names; signs are the
    model's: power is positive along the half arrow. A switch is a choice (`if_else`) that follows
    its condition; jumps (`when`) are left out, and sampled values are those at the start. Algebraic
    states have empty rows in M.

    Attributes
    ----------
    states, inputs, parameters, outputs
        The names of the entries of x, u, p and y.
    t, x, u, p
        The symbols: time in s, and columns of as many rows as there are names.
    f, g
        Columns of the right-hand sides and of the outputs.
    M
        The mass matrix, (n, n), of parameters alone.
    A, B, C, D
        df/dx, df/du, dg/dx, dg/du, sparse. They are finite where CasADi's own derivatives of f are
        not, as those of a norm at zero.
    start
        The state at the start, (n,), that a run of the scene has.
    values
        The scene's number for each parameter.
    given
        The scene's value of each input, in t and p: that of its source, or 0 where the input is
        added to what the scene has.

    Examples
    --------
    >>> crane = bgc.compile("crane.bg").casadi(["slew.f"], ["tip.x"])  # doctest: +SKIP
    >>> crane.function().generate("crane.c")  # doctest: +SKIP
    >>> step = casadi.integrator("step", "cvodes", crane.dae(), 0, 0.1)  # doctest: +SKIP
    """

    states: tuple[str, ...]
    inputs: tuple[str, ...]
    parameters: tuple[str, ...]
    outputs: tuple[str, ...]
    t: SX
    x: SX
    u: SX
    p: SX
    f: SX
    g: SX
    M: SX
    A: SX
    B: SX
    C: SX
    D: SX
    start: Array
    values: Array
    given: SX
    _differential: tuple[int, ...]

    @property
    def rates(self) -> SX:
        """X' of all states as a column: M divided out.

        Raises
        ------
        BgError
            There are algebraic states (BG794): use `dae`.
        """
        if len(self._differential) < len(self.states):
            raise BgError([singular_mass()])
        casadi = _casadi()
        return self.f if self.M.is_eye() else casadi.solve(self.M, self.f)

    def dae(self) -> dict[str, SX]:
        """The equations as `casadi.integrator` takes them; its `p` is u above p.

        `x` are the states with a rate, `z` the algebraic ones.
        """
        casadi = _casadi()
        rated = list(self._differential)
        algebraic = sorted(set(range(len(self.states))) - set(rated))
        mass, rates = self.M[rated, rated], self.f[rated]
        return {
            "t": self.t,
            "x": self.x[rated],
            "z": self.x[algebraic],
            "p": casadi.vertcat(self.u, self.p),
            "ode": rates if mass.is_eye() else casadi.solve(mass, rates),
            "alg": self.f[algebraic],
        }

    def function(self, name: str = "equations") -> Any:
        """A `casadi.Function` from t, x, u, p to f, g, A, B, C, D, which can generate C."""
        names = (["t", "x", "u", "p"], ["f", "g", "A", "B", "C", "D"])
        arguments = [self.t, self.x, self.u, self.p]
        results = [self.f, self.g, self.A, self.B, self.C, self.D]
        return _casadi().Function(name, arguments, results, *names)

    def __repr__(self) -> str:
        counts = (("state", self.states), ("input", self.inputs), ("output", self.outputs))
        found = ", ".join(f"{len(names)} {word}{'s'[: len(names) != 1]}" for word, names in counts)
        return f"<bgc CasADi model: {found}>"


def _casadi() -> ModuleType:
    found: ModuleType = optional_package("casadi", "`casadi`")
    return found


def casadi_model(
    path: Path,
    options: Options,
    inputs: Sequence[str],
    outputs: Sequence[str],
    values: Mapping[str, float],
) -> CasadiModel:
    """A scene as CasADi expressions, as `bgc.Model.casadi` says."""
    casadi = _casadi()
    opened = open_scene(path, options, inputs, outputs, values, total=True)
    program = opened.program
    symbols = _Symbols(casadi, opened)
    form = linear_form(opened)
    n, m, outs = len(program.states), len(opened.inputs), len(program.observations)

    def column(dag: Dag, nodes: Iterable[Node]) -> SX:
        return casadi.vertcat(casadi.SX(0, 1), *symbols.expressions(dag, nodes))

    def block(entries: Entries, first: int, rows: int, columns: int) -> SX:
        chosen = [(row - first, k, node) for row, k, node in entries if 0 <= row - first < rows]
        nodes = [node for _, _, node in chosen]
        places = [[row for row, _, _ in chosen], [k for _, k, _ in chosen]]
        return casadi.SX.triplet(*places, column(form.dag, nodes), rows, columns)

    whole = column(form.dag, (*form.rates, *form.outputs))
    mass = casadi.SX.eye(n)
    if program.mass is not None:
        mass = casadi.SX(n, n)
        made = symbols.expressions(program.dag, [e.value for e in program.mass])
        for entry, value in zip(program.mass, made, strict=True):
            mass[entry.row, entry.column] = value
    entered = {e.row for e in program.mass} if program.mass is not None else set(range(n))
    start = OpenedModel(path, options, inputs, outputs, values)
    found = dict(
        zip((s.name for s in start.opened.program.states), start.at_start().state, strict=True)
    )
    return CasadiModel(
        states=tuple(state.name for state in program.states),
        inputs=tuple(varied.name for varied in opened.inputs),
        parameters=tuple(parameter.name for parameter in program.parameters),
        outputs=tuple(observation.name for observation in program.observations),
        t=symbols.t,
        x=symbols.x,
        u=symbols.u,
        p=symbols.p,
        f=whole[:n],
        g=whole[n:],
        M=mass,
        A=block(form.by_state, 0, n, n),
        B=block(form.by_input, 0, n, m),
        C=block(form.by_state, n, outs, n),
        D=block(form.by_input, n, outs, m),
        start=np.array([found[state.name] for state in program.states]),
        values=np.array([symbols.numbers[Symbol(Kind.PARAM, q.index)] for q in program.parameters]),
        given=column(
            program.dag, [program.dag.zero if v.given is None else v.given for v in opened.inputs]
        ),
        _differential=tuple(sorted(entered)),
    )


class _Symbols:
    """The CasADi symbols of an opened program, and what stands for each symbol of its graph."""

    def __init__(self, casadi: ModuleType, opened: Opened) -> None:
        program = opened.program
        symbol = casadi.SX.sym
        self._casadi, self._zero = casadi, casadi.SX(0)
        self.numbers = program_values(program)
        self.t = symbol("t")
        self.x = _column(casadi, [state.name for state in program.states])
        self.p = _column(casadi, [parameter.name for parameter in program.parameters])
        self.u = _column(casadi, [varied.name for varied in opened.inputs])
        self._inputs = {varied.index: self.u[k] for k, varied in enumerate(opened.inputs)}
        sampled = self.expressions(program.dag, [h.initial for h in program.held])
        for held, first in zip(program.held, sampled, strict=True):
            self._inputs[held.index] = casadi.substitute(first, self.t, 0)

    def expressions(self, dag: Dag, nodes: Iterable[Node]) -> list[SX]:
        """Nodes of a graph in these symbols."""
        return expressions(self._casadi, dag, nodes, self.of, self.numbers)

    def of(self, symbol: Symbol) -> SX:
        """The expression of a symbol; an input that is not chosen is zero."""
        match symbol.kind:
            case Kind.PARAM:
                return self.p[symbol.index]
            case Kind.STATE:
                return self.x[symbol.index]
            case Kind.TIME:
                return self.t
            case Kind.SELECTOR:
                return self._casadi.SX(self.numbers[symbol])
            case _:
                return self._inputs.get(symbol.index, self._zero)


def _column(casadi: ModuleType, names: Sequence[str]) -> SX:
    return casadi.vertcat(casadi.SX(0, 1), *(casadi.SX.sym(name) for name in names))
