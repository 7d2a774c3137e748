"""The port-Hamiltonian form of a part, from its elements in the flat graph."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from scipy.linalg import cholesky, solve_triangular

from bgc.algebra.dag import Kind, Level
from bgc.algebra.derivatives import gradient
from bgc.algebra.evaluate import evaluate_nodes
from bgc.ir.graph import Element, Node
from bgc.record_class import dataclass
from bgc.runtime.reduced_parts.elimination import solve_for
from bgc.runtime.reduced_parts.part_equations import PartEquations
from bgc.runtime.reduced_parts.part_laws import Laws
from bgc.runtime.reduced_parts.port_hamiltonian import PortHamiltonian
from bgc.runtime.results.arrays import Array

_ROUNDING = 1e-9  # of the largest entry of a matrix in states that count in energy


@dataclass(frozen=True, slots=True)
class PartPort:
    """A scalar port: its bond, and +1 where positive power runs into the part, else -1."""

    bond: int
    sign: int


@dataclass(frozen=True, slots=True, eq=False)
class PartSystem:
    """A part in port-Hamiltonian form.

    `by_effort` says for each scalar port if its input is the effort; the other variable is its
    output. Flows count into the part. `linear` marks the outputs that are linear in the part's
    variables; rows of others are zero.
    """

    system: PortHamiltonian
    by_effort: tuple[bool, ...]
    linear: tuple[bool, ...]


def part_system(
    elements: Sequence[Element], ports: Sequence[PartPort], outputs: Sequence[Node], laws: Laws
) -> PartSystem:
    """Derive the port-Hamiltonian form of a part.

    The input of a port is its flow where the part allows it, and its effort where the flow follows
    from the states, or where fewer resistors then stand between states and inputs.

    Parameters
    ----------
    elements
        Those of the part.
    ports
        Its scalar ports, by the bonds that join it to the rest.
    outputs
        Further nodes in the variables of the part.
    laws
        The numbers of its laws.

    Raises
    ------
    BgError
        A law varies with something else than its own variables, or the part has no such form.
    """
    equations = PartEquations(elements, laws)
    rows = _rows_of_outputs(equations, outputs)
    found = _Derivation(equations, ports, [False] * len(ports))
    for k in range(len(ports)):
        if found.coupling == 0:
            break
        turned = [each != (j == k) for j, each in enumerate(found.by_effort)]
        other = _Derivation(equations, ports, turned)
        if other.coupling < found.coupling:
            found = other
    if not np.isfinite(found.coupling):
        laws.refuse("its ports are joined to one another, or held by sources")
    if found.lossy < -_ROUNDING:
        laws.refuse("it supplies power: one of its resistors or stores is not passive")
    further = np.array([row for row in rows if row is not None]).reshape(-1, equations.size)
    linear = tuple(row is not None for row in rows)
    return PartSystem(found.system(further), tuple(found.by_effort), linear)


class _Derivation:
    """A part's variables by states and inputs, for one choice of inputs.

    `coupling` measures the resistors between states and inputs (P), infinite where there is no
    form; `lossy` is the least eigenvalue of the dissipation over its largest entry.
    """

    def __init__(
        self, equations: PartEquations, ports: Sequence[PartPort], by_effort: Sequence[bool]
    ) -> None:
        self.equations = equations
        self.coupling, self.lossy = float("inf"), 0.0
        self.by_effort = list(by_effort)
        self.variables = [2 * k + is_flow for k, is_flow in equations.stored]
        rates = [2 * k + (not is_flow) for k, is_flow in equations.stored]
        places = [2 * equations.place[port.bond] for port in ports]
        priority = np.zeros(equations.size)
        priority[rates] = 1
        for place, effort in zip(places, by_effort, strict=True):
            priority[place], priority[place + 1] = (3, 2) if effort else (2, 3)
        priority[self.variables] = 4
        priority[-1] = 5
        order = np.argsort(priority, kind="stable").tolist()
        found = solve_for(np.array(equations.rows), order)
        column = {variable: k for k, variable in enumerate(found.free)}
        inputs = [place + (place not in column) for place in places]
        self.by_effort = [place in column for place in places]
        own = [v for v in dict.fromkeys(self.variables) if v in column]
        chosen = [*own, *inputs, equations.size - 1]
        if not set(chosen) <= column.keys() or len(set(chosen)) < len(chosen):
            return
        self.solved = found.by_free[:, [column[v] for v in chosen]]
        others = np.delete(found.by_free, [column[v] for v in chosen], axis=1)
        n, m = len(own), len(ports)
        follow = self.solved[self.variables][:, :n]
        if not _is_zero(self.solved[self.variables][:, n : n + m]) or not _is_zero(
            np.vstack([others[self.variables], follow.T @ others[rates]])
        ):
            return
        signs = np.array([port.sign for port in ports], dtype=float)
        outputs = [place + effort for place, effort in zip(places, self.by_effort, strict=True)]
        of_outputs = np.where(self.by_effort, signs, 1.0)
        of_inputs = np.where(self.by_effort, 1.0, signs)
        mass = follow.T @ equations.masses() @ follow
        try:
            factor = cholesky(mass, lower=True)
        except np.linalg.LinAlgError:
            return
        self.factor = factor
        self.solved[:, n : n + m] *= of_inputs
        self.solved[:, :n] = solve_triangular(factor, self.solved[:, :n].T, lower=True).T
        rate = solve_triangular(factor, follow.T @ self.solved[rates], lower=True)
        output = of_outputs[:, None] * self.solved[outputs]
        whole = np.vstack([rate, -output])
        square = whole[:, : n + m]
        self.constant = np.concatenate([rate[:, -1], output[:, -1]])
        self.interconnection = (square - square.T) / 2
        self.dissipation = -(square + square.T) / 2
        self.states = n
        self.coupling = float(np.abs(self.dissipation[:n, n:]).max(initial=0.0))
        size = np.abs(square).max(initial=0.0)
        if self.coupling <= _ROUNDING * size:
            self.dissipation[:n, n:] = self.dissipation[n:, :n] = self.coupling = 0.0
        least = np.linalg.eigvalsh(self.dissipation).min(initial=0.0)
        self.lossy = float(least) / size if size else 0.0

    def system(self, outputs: Array) -> PortHamiltonian:
        """The form, with further outputs as rows of the variables, and the states at the start."""
        at = self.equations.variables_at_start()
        follow = self.solved[self.variables][:, : self.states]
        own: Array = np.linalg.lstsq(follow, at, rcond=None)[0].astype(float)
        return PortHamiltonian(
            states=self.states,
            interconnection=self.interconnection,
            dissipation=self.dissipation,
            constant=self.constant,
            outputs=outputs @ self.solved,
            start=own,
        )


def _is_zero(values: Array) -> bool:
    return float(np.abs(values).max(initial=0.0)) <= _ROUNDING


def _rows_of_outputs(equations: PartEquations, outputs: Sequence[Node]) -> list[Array | None]:
    """Each output as a row of the variables; None where it is not linear in them."""
    dag, laws = equations.laws.dag, equations.laws
    symbols = equations.symbols()
    found: list[Array | None] = []
    for node in outputs:
        inside = dag.symbols_in([node])
        own = {n: s for n, s in inside.items() if s.kind is not Kind.PARAM}
        slopes = gradient(dag, node, own)
        if not all(s in symbols for s in own.values()) or any(
            dag.level[slope] > Level.PARAM for slope in slopes
        ):
            found.append(None)
            continue
        values = {**laws.values, **dict.fromkeys(own.values(), 0.0)}
        rest, *numbers = evaluate_nodes(dag, [node, *slopes], values)
        row = rest * equations.unit(equations.size - 1)
        for symbol, number in zip(own.values(), numbers, strict=True):
            row = row + number * symbols[symbol]
        found.append(row if np.isfinite(row).all() else None)
    return found
