"""An opened scene in letters: its linear form at an operating point, its numbers."""

from __future__ import annotations

from collections.abc import Callable, Collection, Iterable, Mapping, Sequence
from fractions import Fraction
from functools import cached_property
from typing import TypeAlias

import sympy

from bgc.algebra.dag import Dag, Kind, Symbol
from bgc.algebra.derivatives import gradient
from bgc.algebra.evaluate import evaluate_nodes
from bgc.algebra.newton import Rows
from bgc.diagnostics.catalogue import symbolic as catalogue
from bgc.diagnostics.diagnostic import BgError
from bgc.ir.defaults import program_values
from bgc.ir.graph import Node
from bgc.linearising.analysis_scene import Opened
from bgc.linearising.linear_form import linear_form
from bgc.symbolic.letters import Letters, positive_letters
from bgc.symbolic.pencil import LinearSystem
from bgc.symbolic.sympy_expressions import expressions

MOST_OPERATIONS = 100_000  # converted at a time, counted without sharing

Blocks: TypeAlias = dict[str, dict[tuple[int, int], Node]]
Value: TypeAlias = "float | Fraction | sympy.Expr"


class SymbolicSystem:
    """The equations of an opened scene and their derivatives, as SymPy expressions.

    `point` is the operating point: values of letters by name, put into derivatives.
    """

    def __init__(self, opened: Opened, point: Mapping[str, sympy.Expr]) -> None:
        self.opened, self.program = opened, opened.program
        self.letters = Letters(opened)
        self._point = point

    # --- nodes --------------------------------------------------------------------------------

    @cached_property
    def _form(self) -> tuple[Dag, Blocks]:
        form = linear_form(self.opened)
        n = len(self.program.states)
        blocks: Blocks = {"A": {}, "B": {}, "C": {}, "D": {}}
        for entries, above, below in ((form.by_state, "A", "C"), (form.by_input, "B", "D")):
            for row, column, node in entries:
                name, place = (above, row) if row < n else (below, row - n)
                blocks[name][place, column] = node
        return form.dag, blocks

    def _mass(self) -> dict[tuple[int, int], Node]:
        mass = self.program.mass
        if mass is None:
            return {(k, k): self.program.dag.one for k in range(len(self.program.states))}
        return {(entry.row, entry.column): entry.value for entry in mass}

    # --- expressions --------------------------------------------------------------------------

    def general(self, nodes: Sequence[Node], dag: Dag | None = None) -> list[sympy.Expr]:
        """Nodes of the program as expressions in its letters, at any state."""
        what = f"a formula of scene `{self.program.scene.name}`"
        return self._converted(what, dag or self.program.dag, nodes, self.letters.of)

    def _at_point(self, what: str, nodes: Sequence[Node]) -> list[sympy.Expr]:
        """Nodes of the linear form as expressions at the operating point."""
        found = self._converted(what, self._form[0], nodes, self._leaf)
        plain = {dummy: letter for letter, dummy in self._positive.items()}
        return [e.xreplace(plain) for e in found] if plain else found

    @staticmethod
    def _converted(
        what: str, dag: Dag, nodes: Sequence[Node], leaf: Callable[[Symbol], sympy.Expr]
    ) -> list[sympy.Expr]:
        """Nodes as expressions; BG094 if they are too long, BG097 if one divides by zero."""
        _require_size(what, dag, nodes)
        try:
            return expressions(dag, nodes, leaf)
        except ZeroDivisionError:
            raise BgError([catalogue.undefined_at(what)]) from None

    def _leaf(self, symbol: Symbol) -> sympy.Expr:
        letter = self.letters.of(symbol)
        if not letter.is_Symbol:
            return letter
        return self._point.get(letter.name, letter).xreplace(self._positive)

    @cached_property
    def _positive(self) -> dict[sympy.Symbol, sympy.Dummy]:
        """Positive symbols that replace letters while a point is put in, so that roots simplify."""
        if not any(e.free_symbols for e in self._point.values()):
            return {}
        return positive_letters(self.numbers())

    def block(self, name: str, shape: tuple[int, int]) -> sympy.Matrix:
        """A, B, C or D of the linear form, at the operating point."""
        nodes = self._form[1][name]
        found = self._at_point(f"the matrix {name}", list(nodes.values()))
        return _matrix(shape, nodes, found)

    def mass(self) -> sympy.Matrix:
        """M of `M x' = f`."""
        nodes = self._mass()
        size = len(self.program.states)
        return _matrix((size, size), nodes, self.general(list(nodes.values())))

    def derivatives(self, nodes: Sequence[Node], by: str) -> list[sympy.Expr]:
        """The derivatives of nodes by a parameter, and by those that follow from it."""
        dag = self.program.dag.copy()
        symbols = [dag.symbol(Kind.PARAM, p.index) for p in self.program.parameters]
        rows = [gradient(dag, node, symbols) for node in nodes]
        flat = self.general([node for row in rows for node in row], dag)
        letter = sympy.Symbol(by)
        weights = [follow(p, letter, self.dependent) for p in self.letters.parameters]
        width = len(weights)
        return [
            sympy.Add(*(e * w for e, w in zip(flat[k : k + width], weights, strict=True)))
            for k in range(0, len(flat), width)
        ]

    # --- numbers and defaults -----------------------------------------------------------------

    @cached_property
    def dependent(self) -> dict[sympy.Symbol, sympy.Expr]:
        """Parameters with defaults that follow from others, and these defaults."""
        dag = self.program.dag
        held = [
            p
            for p in self.program.parameters
            if any(dag.symbol_of(node) is not None for node in dag.reachable([p.value]))
        ]
        found = self.general([p.value for p in held])
        return {sympy.Symbol(p.name): e for p, e in zip(held, found, strict=True)}

    def given(self) -> dict[sympy.Symbol, sympy.Expr]:
        """The scene's values of the inputs that stand for a source as a whole."""
        inputs = [(v.name, v.given) for v in self.opened.inputs if v.given is not None]
        found = self.general([node for _, node in inputs])
        return {sympy.Symbol(name): e for (name, _), e in zip(inputs, found, strict=True)}

    def start(
        self, states: Collection[sympy.Symbol] | None = None
    ) -> dict[sympy.Symbol, sympy.Expr]:
        """Initial values of some states, by default of all, with the scene's inputs.

        Algebraic states have none: the equations determine them.
        """
        chosen = [
            (letter, state.initial)
            for letter, state in zip(self.letters.states, self.program.states, strict=True)
            if state.kind != "algebraic" and (states is None or letter in states)
        ]
        found = self.general([node for _, node in chosen])
        first = {**self.given(), self.letters.time: sympy.S.Zero}
        return {
            letter: e.xreplace(first).xreplace({self.letters.time: sympy.S.Zero})
            for (letter, _), e in zip(chosen, found, strict=True)
        }

    def numbers(self) -> dict[sympy.Symbol, float]:
        """The scene's value of each letter, SI, states and inputs at the start."""
        program, dag = self.program, self.program.dag
        values = program_values(program)
        values[Symbol(Kind.TIME, 0)] = 0.0
        values.update((Symbol(Kind.INPUT, k), 0.0) for k in range(program.inputs))
        starts = evaluate_nodes(dag, [held.initial for held in program.held], values)
        for held, start in zip(program.held, starts, strict=True):
            values[Symbol(Kind.INPUT, held.index)] = start
        for varied in self.opened.inputs:
            if varied.given is not None:
                (value,) = evaluate_nodes(dag, [varied.given], values)
                values[Symbol(Kind.INPUT, varied.index)] = value
        initial = evaluate_nodes(dag, [s.initial for s in program.states], values)
        values.update((Symbol(Kind.STATE, k), x) for k, x in enumerate(initial))
        values.update(self._algebraic(values))
        found = {self.letters.of(symbol): x for symbol, x in values.items()}
        return {letter: found[letter] for letter in self.letters.all if letter in found}

    def _algebraic(self, values: Mapping[Symbol, float]) -> dict[Symbol, float]:
        """The states without a rate, solved from the equations without one; else their starts."""
        count = range(len(self.program.states))
        mass = self._mass()
        rows, columns = ([k for k in count if k not in {e[side] for e in mass}] for side in (0, 1))
        if not rows or len(rows) != len(columns):
            return {}
        unknowns = [Symbol(Kind.STATE, k) for k in columns]
        residuals = [self.program.states[k].derivative for k in rows]
        solver = Rows(self.program.dag.copy(), residuals, unknowns)
        found = solver.solve(values, [values[x] for x in unknowns])
        return dict(zip(unknowns, found or (), strict=False))

    # --- transfer functions -------------------------------------------------------------------

    def linear_system(self, what: str) -> LinearSystem:
        """The linear form at the operating point, to make a transfer function of; `what` it is."""
        blocks = self._form[1]
        return LinearSystem(
            size=len(self.program.states),
            M=self._mass(),
            A=blocks["A"],
            B=blocks["B"],
            C=blocks["C"],
            D=blocks["D"],
            laplace=self.letters.laplace,
            letters=self.letters.all,
            convert=lambda nodes: self._at_point(what, nodes),
        )


def follow(
    letter: sympy.Symbol, by: sympy.Symbol, dependent: Mapping[sympy.Symbol, sympy.Expr]
) -> sympy.Expr:
    """The derivative of one parameter by another, which it may follow from."""
    if letter == by:
        return sympy.S.One
    if letter not in dependent:
        return sympy.S.Zero
    return derivative(dependent[letter], by, dependent)


def derivative(
    expression: sympy.Expr, by: sympy.Symbol, dependent: Mapping[sympy.Symbol, sympy.Expr]
) -> sympy.Expr:
    """The derivative by a parameter, and by way of all that follow from it."""
    symbols = sorted(expression.free_symbols, key=str)
    weights = ((symbol, follow(symbol, by, dependent)) for symbol in symbols)
    return sympy.Add(*(expression.diff(x) * weight for x, weight in weights if weight != 0))


def exact(value: Value) -> sympy.Expr:
    """A value as a SymPy expression; a float is the rational that it is exactly."""
    if isinstance(value, sympy.Basic):
        return value
    fraction = Fraction(value)
    return sympy.Rational(fraction.numerator, fraction.denominator)


def _matrix(
    shape: tuple[int, int], places: Iterable[tuple[int, int]], values: Iterable[sympy.Expr]
) -> sympy.Matrix:
    matrix = sympy.zeros(*shape)
    for place, value in zip(places, values, strict=True):
        matrix[place] = value
    return matrix


def _require_size(what: str, dag: Dag, nodes: Sequence[Node]) -> None:
    """Refuse nodes that are long when written out: SymPy's own algorithms walk trees."""
    size: dict[Node, int] = {}
    for node in dag.reachable(nodes):
        operands = dag.operands(node)
        size[node] = 1 + sum(size[x] for x in operands) if operands else 0
    length = sum(size[node] for node in nodes)
    if length > MOST_OPERATIONS:
        measure = f"its equations have {length:,} operations when written out"
        raise BgError([catalogue.too_large(what, measure, f"{MOST_OPERATIONS:,}")])
