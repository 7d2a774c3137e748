"""The equations of a part in the efforts and flows of its bonds."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from scipy.linalg import block_diag

from bgc.algebra.dag import Kind, Symbol
from bgc.ir.graph import (
    Element,
    Form,
    Gyrator,
    Gyristor,
    Junction,
    Port,
    Resistor,
    Source,
    Storage,
    Transformer,
    ports_of,
)
from bgc.runtime.reduced_parts.part_laws import Laws, symbols_of
from bgc.runtime.results.arrays import Array


class PartEquations:
    """Equations of a part in the efforts and flows of its bonds and a constant one.

    Variable 2 k is the effort of the k-th bond, 2 k + 1 its flow along its own half arrow, and the
    last one is 1. Each effort, flow and equation is a row of coefficients.
    """

    def __init__(self, elements: Sequence[Element], laws: Laws) -> None:
        self.laws = laws
        self.bonds = sorted({port.bond for element in elements for port in ports_of(element)})
        self.place = {bond: k for k, bond in enumerate(self.bonds)}
        self.size = 2 * len(self.bonds) + 1
        self.rows: list[Array] = []
        self.stores = [element for element in elements if isinstance(element, Storage)]
        self.stored_laws = [self._inverted(store) for store in self.stores]
        for element in elements:
            self._add(element)

    @property
    def stored(self) -> list[tuple[int, bool]]:
        """The bond, by its place, of each port of storage, and True for an inertia."""
        ports = ((store, port) for store in self.stores for port in store.ports)
        return [(self.place[port.bond], store.kind == "I") for store, port in ports]

    def masses(self) -> Array:
        """M of `q = M e` and `p = M f`, over all ports of storage."""
        return np.asarray(block_diag(*(slope for slope, _ in self.stored_laws)), dtype=float)

    def variables_at_start(self) -> Array:
        """The efforts of compliances and flows of inertias at the start."""
        at = self.laws.at
        stored = np.array([at.get(symbol, 0.0) for symbol in self._stored_symbols()])
        offset = np.concatenate([np.zeros(0), *(offset for _, offset in self.stored_laws)])
        found: Array = np.linalg.solve(self.masses(), stored - offset)
        return found

    def symbols(self) -> dict[Symbol, Array]:
        """The row of each symbol of the part's variables."""
        found = {}
        for bond, k in self.place.items():
            found[Symbol(Kind.EFFORT, bond)] = self.unit(2 * k)
            found[Symbol(Kind.FLOW, bond)] = self.unit(2 * k + 1)
        for store, (slope, offset) in zip(self.stores, self.stored_laws, strict=True):
            given = self.efforts(store.ports) if store.kind == "C" else self.flows(store.ports)
            rows = slope @ given + self.constants(offset)
            found.update(zip(symbols_of(store), rows, strict=True))
        return found

    def _stored_symbols(self) -> list[Symbol]:
        return [symbol for store in self.stores for symbol in symbols_of(store)]

    def _inverted(self, store: Storage) -> tuple[Array, Array]:
        """The slope and offset of `q = M e + offset`, of an inertia `p = M f + offset`."""
        law = self.laws.storage(store)
        if law.form in (Form.DISPLACEMENT, Form.MOMENTUM):
            return law.slope, law.offset
        try:
            slope: Array = np.linalg.inv(law.slope).astype(float)
        except np.linalg.LinAlgError:
            self.laws.refuse(f"`{store.name}` has no stiffness in some direction")
        return slope, -slope @ law.offset

    def unit(self, k: int) -> Array:
        """The row of one variable."""
        found = np.zeros(self.size)
        found[k] = 1.0
        return found

    def efforts(self, ports: Sequence[Port]) -> Array:
        """The efforts at ports, (ports, variables)."""
        return np.array([self.unit(2 * self.place[port.bond]) for port in ports])

    def flows(self, ports: Sequence[Port]) -> Array:
        """The flows into an element at its ports, (ports, variables)."""
        return np.array([p.sign * self.unit(2 * self.place[p.bond] + 1) for p in ports])

    def constants(self, values: Array) -> Array:
        """Constants, (values, variables)."""
        return np.outer(values, self.unit(self.size - 1))

    def _add(self, element: Element) -> None:
        """Add the equations of an element; storage has none, its variables are given."""
        efforts, flows = self.efforts(ports_of(element)), self.flows(ports_of(element))
        match element:
            case Junction(kind="J0"):
                self.rows.extend(efforts[1:] - efforts[0])
                self.rows.append(flows.sum(axis=0))
            case Junction(ports=ports):
                signs = np.array([[port.sign] for port in ports])
                along = signs * flows
                self.rows.extend(along[1:] - along[0])
                self.rows.append((signs * efforts).sum(axis=0))
            case Source(kind=kind, value=value, port=port):
                given = efforts if kind == "Se" else port.sign * flows
                self.rows.extend(given - self.constants(self.laws.numbers(element.name, [value])))
            case Resistor():
                law = self.laws.resistor(element)
                left, right = (efforts, flows) if law.form is Form.EFFORT else (flows, efforts)
                self.rows.extend(left - law.slope @ right - self.constants(law.offset))
            case Transformer(given=given):
                n, M = len(element.ports1), self.laws.matrix(element.name, element.matrix)
                (e1, e2), (f1, f2) = (efforts[:n], efforts[n:]), (flows[:n], -flows[n:])
                if given in ("f2", "e1"):
                    self.rows.extend([*(f2 - M @ f1), *(e1 - M.T @ e2)])
                else:
                    self.rows.extend([*(f1 - M @ f2), *(e2 - M.T @ e1)])
            case Gyrator():
                n, M = len(element.ports1), self.laws.matrix(element.name, element.matrix)
                self.rows.extend([*(efforts[n:] - M @ flows[:n]), *(efforts[:n] + M.T @ flows[n:])])
            case Gyristor():
                M = self.laws.matrix(element.name, element.matrix)
                self.rows.extend(efforts - M @ flows)
            case Storage():
                pass
