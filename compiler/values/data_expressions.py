"""Data in expressions: a file with its columns or keys, and numbers that need not be nodes."""

from __future__ import annotations

from bgc.algebra.dag import Dag
from bgc.diagnostics.catalogue import data as catalogue
from bgc.diagnostics.catalogue import shapes as shape_messages
from bgc.diagnostics.source import Span
from bgc.grammar import syntax
from bgc.record_class import dataclass
from bgc.values.arithmetic import failure
from bgc.values.component_selection import Selection
from bgc.values.data_files import Entries, Numbers
from bgc.values.value import Value, describe_shape

MOST_NODES = 10_000  # numbers of a column that may be used otherwise than by `interpolate`


@dataclass(frozen=True, slots=True)
class Table:
    """A data file, or the values under one of its keys."""

    file: str
    path: str
    entries: Entries

    @property
    def description(self) -> str:
        """For messages."""
        return (
            f"`{self.path}` of the data in `{self.file}`"
            if self.path
            else f"the data in `{self.file}`"
        )

    def member(self, name: str, span: Span) -> Table | Column:
        """A column or key."""
        found = self.entries.get(name)
        if found is None:
            raise failure(
                catalogue.data_missing_name(span, name, self.description, list(self.entries))
            )
        path = f"{self.path}.{name}" if self.path else name
        return (
            Column(self.file, found)
            if isinstance(found, Numbers)
            else Table(self.file, path, found)
        )

    def index(self, indices: tuple[int, ...], span: Span) -> Table | Column:
        """A table has names, not numbers."""
        raise failure(
            catalogue.data_missing_name(span, str(indices[0]), self.description, list(self.entries))
        )


@dataclass(frozen=True, slots=True)
class Column:
    """Numbers of a data file: one, a vector or a matrix. They become nodes where few are used."""

    file: str
    numbers: Numbers

    @property
    def description(self) -> str:
        """For messages."""
        return (
            f"`{self.numbers.name}` of `{self.file}`, {describe_shape(self.numbers.array.shape)},"
        )

    def member(self, name: str, span: Span) -> Column:
        """Component `.x`, `.y` or `.z` of a vector."""
        axes, array = "xyz", self.numbers.array
        if len(name) == 1 and name in axes and array.ndim == 1 and len(array) > axes.index(name):
            return self._of(array[axes.index(name)])
        raise failure(shape_messages.no_component(span, name, describe_shape(array.shape)))

    def index(self, indices: tuple[int, ...], span: Span) -> Column:
        """One number."""
        return self.select(tuple(Selection(k, k, True, span) for k in indices), span)

    def select(self, selections: tuple[Selection, ...], span: Span) -> Column:
        """Components, as `values.components.select` gives them."""
        array = self.numbers.array
        shape = describe_shape(array.shape)
        if len(selections) != array.ndim:
            found = len(selections)
            raise failure(shape_messages.wrong_index_count(span, shape, array.ndim, found))
        for selection, size in zip(selections, array.shape, strict=True):
            for place in (selection.first, selection.last):
                if not 1 <= place <= size:
                    raise failure(
                        shape_messages.index_out_of_range(selection.span, place, size, shape)
                    )
        return self._of(
            array[
                tuple(s.first - 1 if s.single else slice(s.first - 1, s.last) for s in selections)
            ]
        )

    def value(self, dag: Dag, span: Span) -> Value:
        """The numbers as nodes; refused if there are too many."""
        array = self.numbers.array
        if array.size > MOST_NODES:
            raise failure(catalogue.data_too_long(span, self.numbers.name, array.size, MOST_NODES))
        nodes = tuple(dag.const(float(x)) for x in array.ravel().tolist())
        return Value.uniform(array.shape, nodes, self.numbers.unit)

    def _of(self, array: object) -> Column:
        import numpy as np  # takes longer to load than most models to compile

        numbers = self.numbers
        return Column(self.file, Numbers(numbers.name, np.asarray(array), numbers.unit))


def may_be_data(expr: syntax.Expr | None) -> bool:
    """Return whether an expression is a path, or the call of `data` at the start of one."""
    while isinstance(expr, syntax.Member | syntax.Index):
        expr = expr.base
    return isinstance(expr, syntax.Name) or (
        isinstance(expr, syntax.Call) and expr.function == "data"
    )
