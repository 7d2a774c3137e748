"""The raw symbols of a causal graph's variables, in the bonds' sense and the elements'."""

from __future__ import annotations

from bgc.algebra.dag import Dag, Kind
from bgc.ir.causal import CausalGraph, ElementPort
from bgc.ir.graph import Node


class Symbols:
    """Through and across variables of bonds, classes and ports, as nodes."""

    def __init__(self, causal: CausalGraph) -> None:
        self._causal = causal
        self._dag: Dag = causal.graph.dag

    def through(self, bond: int) -> Node:
        """The through variable of a bond."""
        return self._dag.symbol(Kind.EFFORT if self._causal.dual[bond] else Kind.FLOW, bond)

    def across(self, bond: int) -> Node:
        """The across variable of a bond."""
        return self._dag.symbol(Kind.FLOW if self._causal.dual[bond] else Kind.EFFORT, bond)

    def of_class(self, number: int) -> Node:
        """The symbol that stands for a class: the through variable of its first bond."""
        return self.through(self._causal.classes[number].bonds[0])

    def port_through(self, port: ElementPort) -> Node:
        """A port's through variable in the element's sense."""
        return self.turned(self.through(port.bond), port.through_sign)

    def port_across(self, port: ElementPort) -> Node:
        """A port's across variable in the element's sense."""
        return self.turned(self.across(port.bond), port.across_sign)

    def turned(self, node: Node, sign: int) -> Node:
        """A node times +1 or -1."""
        return node if sign > 0 else self._dag.neg(node)
