"""Checks of the parameters that the equations of a program divide by or draw numbers with.

Every quotient whose divisor depends on parameters alone is found, whether the model wrote it or the
compiler inverted a law. A quotient that only a branch of `if` needs is not checked, since the
condition may exclude zero. Nor is one whose infinite value does not show, as 1/a in the stiffness
`1/(1/a + 1/b)` of two springs in series: there the whole expression has to be finite.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import replace

from bgc.algebra.dag import Dag, Kind, Level, Op, Symbol
from bgc.algebra.expansion import expanded_text
from bgc.diagnostics.catalogue import listed
from bgc.ir.evaluation import always_evaluated
from bgc.ir.fields import nodes_of
from bgc.ir.graph import Node
from bgc.ir.program import PositiveParameter, Program

_MOST_CHARACTERS = 60  # characters of an expression in a message
_MOST_PARAMETERS = 5  # parameters that a message lists in place of their expression


def with_divisor_checks(program: Program) -> Program:
    """Add checks for the divisors of PARAM level, which run whenever parameters are set.

    Takes time linear in the number of nodes. Divisors that are checked already are left out. Seeds
    and indices of `random` are checked to be whole numbers.
    """
    dag = program.dag
    known = {node for check in program.positive for node in _factors(dag, check.node)}
    selectors = set(program.closures.selectors) - {dag.one} if program.closures else set()
    found = _Search(program)
    added: dict[Node, PositiveParameter] = {}
    unnamed: dict[Node, str] = {}  # long expressions that must be finite: the equation of each
    for owner, roots in _equations(program):
        for node, finite in found.under(roots):
            # A pivot of S, with a selector, is watched during a run.
            is_pivot = selectors and not selectors.isdisjoint(dag.reachable([node]))
            if node in known or node in added or is_pivot:
                continue
            if finite and dag.op[node] == Op.INVERTED:
                message = _of_matrix(_named(program, [node]), owner)
                check = PositiveParameter(node, message, strictly_positive=False, finite=True)
                added[node] = check
                continue
            text = _text(program, node)
            if finite and text is None:
                unnamed[node] = owner
                continue
            message = _message(text or _some_of(program, [node]), owner, finite=finite)
            added[node] = PositiveParameter(node, message, strictly_positive=False, finite=finite)
    # What is drawn first: a seed of 1.5 makes all that is computed from it undefined.
    checks = [*_whole_numbers(program), *added.values(), *_together(program, unnamed)]
    return replace(program, positive=(*program.positive, *checks)) if checks else program


def _together(program: Program, unnamed: Mapping[Node, str]) -> list[PositiveParameter]:
    """One check of all expressions that are too long for a message, such as those of an inverse."""
    if not unnamed:
        return []
    dag = program.dag
    total = dag.sum(dag.call(Op.ABS, node) for node in unnamed)
    message = _message(_some_of(program, unnamed), next(iter(unnamed.values())), finite=True)
    return [PositiveParameter(total, message, strictly_positive=False, finite=True)]


def _whole_numbers(program: Program) -> Iterator[PositiveParameter]:
    """Check the seeds and indices of `random`, which is undefined for other than whole numbers."""
    dag = program.dag
    drawn = [n for n in dag.reachable(nodes_of(program)) if dag.op[n] == Op.RANDOM]
    for what, operands in (("seed", dag.a), ("index", dag.b)):
        for node in dict.fromkeys(operands[n] for n in drawn):
            if dag.level[node] != Level.PARAM:
                continue
            text = _text(program, node) or _some_of(program, [node])
            message = f"{text} must be a whole number: it is the {what} of `random`"
            finite = dag.call(Op.RANDOM, node, dag.zero)
            yield PositiveParameter(finite, message, strictly_positive=False, finite=True)


def _equations(program: Program) -> Iterator[tuple[str, Sequence[Node]]]:
    """The nodes that a run evaluates, with words for messages.

    The scales of tolerances are left out: they are sound for any parameters that pass the checks.
    """
    for state in program.states:
        yield f"the equation of `{state.name}`", [state.derivative]
    for state in program.states:
        yield f"the initial value of `{state.name}`", [state.initial]
    for observation in program.observations:
        yield f"`{observation.name}`", [observation.node]
    for requirement in program.requirements:
        yield f"`{requirement.name}`", [requirement.node]
    for device in program.devices:
        yield f"the command of `{device.name}`", device.values
    for guard in program.guards:
        yield "an `assert`", [guard.condition]
    energy = program.energy
    yield "the energy", [energy.stored, energy.supplied, energy.dissipated]
    yield "the mass matrix", [entry.value for entry in program.mass or ()]


def _message(text: str, owner: str, *, finite: bool) -> str:
    if finite:
        return f"{text} must be finite, but divides by zero: {owner} needs it"
    return f"{text} must not be zero: {owner} divides by it"


def _of_matrix(names: str, owner: str) -> str:
    return f"a matrix of {names} must not be singular: {owner} needs its inverse"


def _text(program: Program, node: Node) -> str | None:
    """The expression for a message, None where it is too long."""

    def name(symbol: Symbol) -> str:
        assert symbol.kind is Kind.PARAM
        return program.parameters[symbol.index].name

    text = expanded_text(program.dag, node, name, _MOST_CHARACTERS)
    return None if text is None else f"`{text}`"


def _some_of(program: Program, nodes: Iterable[Node]) -> str:
    """Words for expressions that are too long for a message."""
    return f"an expression of {_named(program, nodes)}"


def _named(program: Program, nodes: Iterable[Node]) -> str:
    """The parameters of expressions, vectors by their names."""
    indices = sorted(s.index for s in program.dag.symbols_in(nodes, Kind.PARAM).values())
    names = dict.fromkeys(program.parameters[k].name.split("[")[0] for k in indices)
    return listed(list(names), _MOST_PARAMETERS)


class _Search:
    """Finds what has to be nonzero or finite; each node is visited once."""

    def __init__(self, program: Program) -> None:
        self._dag = program.dag
        self._seen: set[Node] = set()
        self._plain: set[Node] = set()  # nodes that evaluate no quotient whose divisor varies
        self._searched: set[Node] = set()  # for inverses
        self._matrices: set[Node] = set()  # ends of the lists of the matrices that were found

    def under(self, roots: Iterable[Node]) -> Iterator[tuple[Node, bool]]:
        """The nodes of PARAM level that must be nonzero, or finite if the flag is set."""
        dag = self._dag
        stack = list(roots)
        while stack:
            node = stack.pop()
            if node in self._seen:
                continue
            self._seen.add(node)
            if dag.level[node] <= Level.PARAM:
                yield from self._required(node)
            elif dag.op[node] == Op.DIV and dag.level[dag.b[node]] <= Level.PARAM:
                stack.append(dag.a[node])
                yield from ((factor, False) for factor in self._divisors(dag.b[node]))
            else:
                stack.extend(always_evaluated(dag, node))

    def _required(self, node: Node) -> Iterator[tuple[Node, bool]]:
        """The conditions for an expression of parameters to be finite."""
        dag = self._dag
        for factor, power in _powers(dag, node, 1):
            yield from ((inverse, True) for inverse in self._inverses(factor))
            if power < 0:
                yield from ((inner, False) for inner in self._divisors(factor))
            elif self._divides(factor):
                yield factor, True

    def _inverses(self, node: Node) -> Iterator[Node]:
        """One entry of each inverse that a node always evaluates and that was not found before."""
        dag, stack = self._dag, [node]
        while stack:
            inner = stack.pop()
            if inner in self._searched:
                continue
            self._searched.add(inner)
            if dag.op[inner] != Op.INVERTED:
                stack.extend(always_evaluated(dag, inner))
            elif dag.a[inner] not in self._matrices:
                self._matrices.add(dag.a[inner])
                yield inner

    def _divisors(self, node: Node) -> Iterator[Node]:
        dag = self._dag
        return (n for n in _factors(dag, node) if dag.level[n] == Level.PARAM)

    def _divides(self, node: Node) -> bool:
        """Return whether a node always evaluates a quotient whose divisor varies."""
        dag, plain = self._dag, self._plain
        stack, seen = [node], {node}
        while stack:
            inner = stack.pop()
            if dag.level[inner] != Level.PARAM or inner in plain:
                continue
            if any(
                power < 0 and dag.level[n] == Level.PARAM for n, power in _powers(dag, inner, 1)
            ):
                return True
            for operand in always_evaluated(dag, inner) if dag.op[inner] != Op.INVERTED else ():
                if operand not in seen:
                    seen.add(operand)
                    stack.append(operand)
        plain |= seen
        return False


def _factors(dag: Dag, node: Node) -> list[Node]:
    """Return the varying factors of a product: it vanishes where one of them does."""
    return list(dict.fromkeys(n for n, power in _powers(dag, node, 1) if power > 0))


def _powers(dag: Dag, node: Node, power: int) -> Iterator[tuple[Node, int]]:
    """The factors of a product with the signs of their powers, roots and signs undone."""
    stack = [(node, power)]
    while stack:
        top, sign = stack.pop()
        match Op(dag.op[top]):
            case Op.MUL:
                stack += [(dag.b[top], sign), (dag.a[top], sign)]
            case Op.DIV:
                stack += [(dag.b[top], -sign), (dag.a[top], sign)]
            case Op.NEG | Op.SQRT | Op.ABS | Op.CBRT:
                stack.append((dag.a[top], sign))
            case Op.POW if (exponent := dag.value(dag.b[top])) is not None and exponent != 0:
                stack.append((dag.a[top], sign if exponent > 0 else -sign))
            case Op.EXP | Op.CONST:
                pass
            case _:
                yield top, sign
