"""The laws of a part's elements as numbers; nonlinear ones by their tangents at the start."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import NoReturn

import numpy as np

from bgc.algebra.dag import Dag, Kind, Level, Symbol
from bgc.algebra.derivatives import gradient
from bgc.algebra.evaluate import evaluate_nodes
from bgc.diagnostics.catalogue.studies import part_not_reduced
from bgc.diagnostics.diagnostic import BgError
from bgc.ir.graph import (
    EnergyLaw,
    ExplicitLaw,
    Form,
    LinearLaw,
    Matrix,
    Node,
    Resistor,
    Storage,
)
from bgc.record_class import dataclass, field
from bgc.runtime.results.arrays import Array

_STORED = {"C": Kind.DISPLACEMENT, "I": Kind.MOMENTUM}


@dataclass(frozen=True, slots=True, eq=False)
class Tangent:
    """A law about a point, `left = slope * right + offset`, in the element's own sense."""

    form: Form
    slope: Array
    offset: Array


@dataclass(slots=True, eq=False)
class Laws:
    """Numbers of the laws of a part.

    Parameters
    ----------
    dag
        A copy of the graph's, for derivatives.
    part
        The path of the part, for messages.
    values
        The parameters' values, SI, by symbol.
    at
        The variables of nonlinear laws at the start. `tangents` lists the elements that have one.
    """

    dag: Dag
    part: str
    values: Mapping[Symbol, float]
    at: Mapping[Symbol, float]
    tangents: list[str] = field(default_factory=list)

    def numbers(self, name: str, nodes: Sequence[Node]) -> Array:
        """Evaluate nodes of constants and parameters; raises BgError if one varies."""
        if any(self.dag.level[node] > Level.PARAM for node in nodes):
            self._refuse_varying(name)
        return np.array(evaluate_nodes(self.dag, nodes, self.values), dtype=float)

    def matrix(self, name: str, matrix: Matrix) -> Array:
        """Evaluate a matrix of constants and parameters; raises BgError if an entry varies."""
        flat = self.numbers(name, [node for row in matrix for node in row])
        return flat.reshape(len(matrix), -1)

    def resistor(self, element: Resistor) -> Tangent:
        """The law of a resistor, of the form EFFORT or FLOW."""
        if isinstance(element.law, LinearLaw):
            return self._linear(element.name, element.law)
        kind = Kind.FLOW if element.law.form is Form.EFFORT else Kind.EFFORT
        own = [Symbol(kind, port.bond) for port in element.ports]
        return self._tangent(element.name, element.law.form, element.law.nodes, own)

    def storage(self, element: Storage) -> Tangent:
        """The law of a C or I, of any form; raises BgError for an IC."""
        if element.kind not in _STORED:
            self.refuse(f"`{element.name}` is an IC")
        own = symbols_of(element)
        form = Form.EFFORT if element.kind == "C" else Form.FLOW
        match element.law:
            case LinearLaw():
                return self._linear(element.name, element.law)
            case ExplicitLaw(nodes=nodes):
                return self._tangent(element.name, form, nodes, own)
            case EnergyLaw(energy=energy):
                symbols = [self.dag.symbol(s.kind, s.index) for s in own]
                return self._tangent(
                    element.name, form, tuple(gradient(self.dag, energy, symbols)), own
                )

    def _linear(self, name: str, law: LinearLaw) -> Tangent:
        slope = self.matrix(name, law.matrix)
        return Tangent(law.form, slope, np.zeros(len(slope)))

    def _tangent(
        self, name: str, form: Form, nodes: Sequence[Node], own: Sequence[Symbol]
    ) -> Tangent:
        """The tangent of a law in its own variables."""
        varying = self.dag.symbols_in(nodes).values()
        if any(s.kind is not Kind.PARAM and s not in own for s in varying):
            self._refuse_varying(name)
        symbols = [self.dag.symbol(s.kind, s.index) for s in own]
        slopes = [node for each in nodes for node in gradient(self.dag, each, symbols)]
        values = {**self.values, **{s: self.at.get(s, 0.0) for s in own}}
        flat = np.array(evaluate_nodes(self.dag, [*nodes, *slopes], values), dtype=float)
        if not np.isfinite(flat).all():
            self._refuse_varying(name)
        slope = flat[len(nodes) :].reshape(len(nodes), -1)
        point = np.array([values[s] for s in own])
        if any(self.dag.level[node] > Level.PARAM for node in slopes):
            self.tangents.append(name)
        return Tangent(form, slope, flat[: len(nodes)] - slope @ point)

    def refuse(self, reason: str) -> NoReturn:
        """Raise the error that the part cannot be reduced."""
        raise BgError([part_not_reduced(self.part, reason)])

    def _refuse_varying(self, name: str) -> NoReturn:
        self.refuse(f"the law of `{name}` depends on more than its own variables and parameters")


def symbols_of(store: Storage) -> list[Symbol]:
    """The displacements of a C, or the momenta of an I."""
    return [Symbol(_STORED[store.kind], store.first_state + k) for k in range(len(store.ports))]
