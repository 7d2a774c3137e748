"""Accelerations of an imported robot at many states at once, evaluated over its graph by NumPy."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from bgc.algebra.dag import Kind, Op
from bgc.algebra.derivatives import directional_derivative
from bgc.algebra.double_inverse import inverse_in_doubles
from bgc.algebra.evaluate import Evaluator as NumberEvaluator
from bgc.algebra.evaluate import NodeEvaluator
from bgc.algebra.operations import ROWS
from bgc.driver import compile_scene
from bgc.options import Options

_ARRAYS = {
    int(Op.ADD): np.add,
    int(Op.SUB): np.subtract,
    int(Op.MUL): np.multiply,
    int(Op.DIV): np.divide,
    int(Op.NEG): np.negative,
}


class _Arrays(NodeEvaluator):
    def _from_leaf(self, value):
        return value

    def _from_operands(self, op, operands):
        if op in _ARRAYS:
            return _ARRAYS[op](*operands)
        if all(np.ndim(x) == 0 for x in operands):
            return self._apply(op, list(operands))
        return np.vectorize(ROWS[op].evaluate, otypes=[float])(*operands)

    def _inverted(self, entries):
        return inverse_in_doubles(entries)


class RobotProbe:
    """A scene that observes `v`, rates that are linear in the momenta, and drives by `u`.

    Parameters
    ----------
    file, scene
        The scene; its model has the parameter `u`.
    """

    def __init__(self, file: Path, scene: str) -> None:
        program = compile_scene(file, Options(scene, whole=True), until="optimise").optimised
        assert program.mass is None
        self.program, self.dag = program, program.dag
        self.states = [state.name for state in program.states]
        self.momenta = [k for k, s in enumerate(program.states) if s.kind == "momentum"]
        flow = {self.dag.symbol(Kind.STATE, k): s.derivative for k, s in enumerate(program.states)}
        observed = [o for o in program.observations if o.name.startswith("v")]
        self.rates = [o.node for o in observed]
        self.accelerations = [directional_derivative(self.dag, o.node, flow) for o in observed]
        self.parameters = [p.name for p in program.parameters]
        assert len(self.momenta) == len(self.rates), (len(self.momenta), len(self.rates))

    def at(self, declared: dict[str, np.ndarray], rates: np.ndarray) -> np.ndarray:
        """States (count, states) with these values of declared states and these rates."""
        states = np.zeros((len(rates), len(self.states)))
        for name, values in declared.items():
            states[:, self.states.index(name)] = values
        size = len(self.momenta)
        mobility = np.empty((len(rates), size, size))
        for j, k in enumerate(self.momenta):
            states[:, self.momenta] = 0
            states[:, k] = 1
            mobility[:, :, j] = self._evaluate(self.rates, states, None)
        states[:, self.momenta] = np.linalg.solve(mobility, rates[..., None])[..., 0]
        return states

    def accelerate(self, states: np.ndarray, efforts: np.ndarray) -> np.ndarray:
        """Rates of `v` (count, n) under efforts (count, n) of the drives on the joints."""
        return self._evaluate(self.accelerations, states, efforts)

    def _evaluate(self, nodes, states, efforts):
        def leaf(symbol):
            kind, index = symbol.kind, symbol.index
            if kind is Kind.STATE:
                return states[:, index]
            if kind is Kind.TIME:
                return 0.0
            name = self.parameters[index]
            if efforts is not None and name.split("[")[0] == "u":
                return efforts[:, int(name[2:-1]) - 1 if "[" in name else 0]
            return self._default(index)

        values = _Arrays(self.dag, leaf).values(nodes)
        return np.stack([np.broadcast_to(v, len(states)) for v in values], axis=-1)

    def _default(self, index):
        value = self.program.parameters[index].value
        return NumberEvaluator(self.dag, lambda symbol: self._default(symbol.index)).value(value)
