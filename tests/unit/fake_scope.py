"""A small world of names in which expressions are evaluated, for tests."""

from __future__ import annotations

from collections.abc import Collection, Hashable, Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass, field
from pathlib import Path

from refusals import refusal

from bgc.algebra.dag import Dag, Kind, Symbol
from bgc.algebra.evaluate import evaluate_nodes
from bgc.diagnostics.catalogue.names import unknown_name
from bgc.diagnostics.catalogue.shapes import index_out_of_range
from bgc.diagnostics.diagnostic import BgError, Diagnostic
from bgc.diagnostics.source import Source, Span
from bgc.grammar import syntax
from bgc.grammar.parse import parse
from bgc.values.data_expressions import Table
from bgc.values.data_files import read_data
from bgc.values.expressions import (
    FunctionUse,
    Namespace,
    evaluate,
)
from bgc.values.units import Dimension, parse_unit
from bgc.values.value import Value

METRE: Dimension = (0, 1, 0, 0, 0, 0, 0)


@dataclass
class Part:
    """A namespace with members and, as an array, elements."""

    members: dict[str, Value | Namespace] = field(default_factory=dict)
    elements: tuple[Namespace, ...] = ()

    @property
    def description(self) -> str:
        return "a part"

    def member(self, name: str, span: Span) -> Value | Namespace:
        if name not in self.members:
            raise BgError([unknown_name(span, name, self.members)])
        return self.members[name]

    def index(self, indices: tuple[int, ...], span: Span) -> Value | Namespace:
        if not 1 <= indices[0] <= len(self.elements):
            raise BgError([index_out_of_range(span, indices[0], len(self.elements), "a part")])
        return self.elements[indices[0] - 1]


@dataclass
class FakeScope:
    values: dict[str, Value | Namespace]
    functions: dict[str, syntax.Function]
    allows_rates: bool = False

    def lookup(self, name: str, span: Span) -> Value | Namespace | None:
        return self.values.get(name)

    def names(self) -> Collection[str]:
        return self.values

    def is_value(self, name: str) -> bool:
        return isinstance(self.values.get(name), Value)

    def component_of(self, name: str) -> None:
        return None  # all values are known

    def function(self, name: str) -> FunctionUse | None:
        found = self.functions.get(name)
        return FunctionUse(found, FakeScope({}, self.functions)) if found else None

    def data(self, file: str, span: Span) -> Namespace:
        return Table(file, "", read_data(Path(file), file, span).entries)

    def function_names(self) -> Collection[str]:
        return self.functions

    def variable(self, path: syntax.Expr, owner: Value | Namespace | None) -> Hashable | None:
        known = isinstance(path, syntax.Name) and isinstance(self.values.get(path.name), Value)
        return path.name if known and path.name.startswith("signal") else None

    @contextmanager
    def assuming(self, values: Mapping[Hashable, Value]) -> Iterator[FakeScope]:
        own = {name: values.get(name, value) for name, value in self.values.items()}
        yield FakeScope(own, self.functions)


class World:
    """A DAG, some names, and texts evaluated among them."""

    def __init__(self, functions: str = "") -> None:
        self.dag = dag = Dag()
        x = [dag.symbol(Kind.STATE, k) for k in range(3)]
        k = dag.symbol(Kind.PARAM)
        coil = Part({"p": Value.scalar(x[0])})
        twist = Value((6,), tuple(x + x), (None, None, None, METRE, METRE, METRE))
        self.scope = FakeScope(
            {
                "x": Value.scalar(x[0]),
                "states": Value.vector(x),
                "v": Value.vector(x, METRE),
                "k": Value.scalar(k),
                "K": Value.uniform((2, 3), [k] * 6),
                "twist": twist,
                "coil": coil,
                "crane": Part({"boom": Part({"mass": Value.scalar(k), "r": Value.vector(x)})}),
                "mass": Part(elements=(coil, coil, coil)),
            },
            {f.name: f for f in _declarations(functions) if isinstance(f, syntax.Function)},
        )

    def evaluate(self, text: str) -> Value:
        return evaluate(expression(text), self.scope, self.dag)

    def numbers(self, text: str) -> list[float]:
        symbols = {Symbol(Kind.STATE, k): k + 2.0 for k in range(3)}
        values = {**symbols, Symbol(Kind.PARAM, 0): 5.0, Symbol(Kind.TIME, 0): 7.0}
        return evaluate_nodes(self.dag, self.evaluate(text).nodes, values)

    def diagnostic(self, text: str) -> Diagnostic:
        return refusal(self.evaluate, text)


def _declarations(text: str) -> tuple[syntax.Declaration, ...]:
    file, diagnostics = parse(Source("test.bg", text))
    assert not diagnostics, diagnostics
    return file.declarations


def expression(text: str) -> syntax.Expr:
    (declaration,) = _declarations(f"const result = {text};")
    assert isinstance(declaration, syntax.Value) and declaration.value is not None
    return declaration.value


def unit(text: str) -> Dimension:
    found = parse_unit(text)
    assert found is not None
    return found.dimension
